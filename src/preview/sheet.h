// sheet.h — panels side by side on one page, with titles, colour bars and captions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "preview/panels.h"
#include "preview/png.h"

namespace malus::preview {

/// By how many pixels a side a picture of this size is too large for a sheet, which takes 640 × 800: 1 if
/// it is not. Numbers are to be reduced so before they become colours (layers.h).
int reduction_for_sheet(int width, int height);

/// A picture that is not too large, enlarged by a whole number to at least 320 pixels in width.
Picture fit_to_sheet(const Picture& picture);

/// Rows of panels; all pictures have one size, as fit_to_sheet() gives it.
Picture make_sheet(const std::string& heading, const std::string& subheading,
                   const std::vector<std::vector<Panel>>& rows, const Font& font);

}  // namespace malus::preview
