// sheet.h — panels side by side on one page, with titles, colour bars and captions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "preview/panels.h"
#include "preview/png.h"

namespace malus::preview {

/// A picture in the size that a sheet shows: small ones enlarged by a whole number to at least 320
/// pixels in width, those beyond 1024 × 1280 reduced by one.
Picture fit_to_sheet(const Picture& picture);

/// One row of panels a wavelength; all pictures have one size, as fit_to_sheet() gives it.
Picture make_sheet(const std::string& heading, const std::string& subheading,
                   const std::vector<std::vector<Panel>>& rows, const Font& font);

}  // namespace malus::preview
