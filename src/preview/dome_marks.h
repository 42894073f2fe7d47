// dome_marks.h — the sun and the neutral points on panels of the dome, in picture and words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "malus/scene/sky.h"
#include "preview/dome.h"
#include "preview/panels.h"

namespace malus::preview {

/// Makes domes of the panels: horizon, letters and, if the sun is known, marks of sun and neutral
/// points at this wavelength of the dome. DoLP's legend and description say where the latter are.
void mark_dome(std::vector<Panel>& panels, const DomeView& view, const std::optional<Sun>& sun,
               const SkyDome& dome, std::size_t wavelength, const Font& font);

/// For the sheet: how the dome is seen, and where the sun stands.
std::string dome_note(const Sky& sky);

}  // namespace malus::preview
