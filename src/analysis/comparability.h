// comparability.h — may two images be compared, and by what may their differences be judged?
//
// By headers and channels alone: what the numbers say is compare.h's.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "malus/analysis/compare.h"
#include "malus/core/error.h"
#include "malus/io/exr.h"

namespace malus {

/// A header's attribute as text, empty if there is none.
std::string attribute(const Image& image, const std::string& name);

/// Both have this attribute, and not the same.
bool differ(const Image& a, const Image& b, const std::string& name);

/// The paints of the header's list, empty if there is none.
std::set<std::string> material_names(const Image& image);

/// What `read` gives, or its Error with the image's place in the comparison ("first", "second").
template <class Read>
auto said_of(const char* which, const Read& read) {
    try {
        return read();
    } catch (const Error& problem) {
        throw Error(std::string("the ") + which + " image: " + problem.what());
    }
}

/// Throws Error (without a file name) for another size, view, frame, handedness or unit.
void check_comparable(const Image& a, const Image& b);

/// Those that are asked for, all for none. Throws Error (without a file name) unless both have the same.
std::vector<double> shared_wavelengths(const Image& a, const Image& b,
                                       const std::vector<double>& asked_nm);

Errors errors_of(const Image& a, const Image& b, const std::vector<double>& wavelengths_nm);

/// What a reader should know of both images, where differences are judged by `errors`.
std::vector<std::string> notes_on(const Image& a, const Image& b, Errors errors);

}  // namespace malus
