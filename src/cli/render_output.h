// render_output.h — what malus render writes and says; the latter in part for malus merge, too.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/render_inputs.h"
#include "malus/io/stats_file.h"

namespace malus::cli {

/// Attributes that say what is rendered and how, whether it came from the command line or a
/// --config file: an image without channels.
Image make_header(const RenderOptions& options, const Inputs& inputs,
                  const RenderSettings& settings, const std::string& command_line);

/// The image and, unless --final, beside it the sums that --resume needs.
void write_image(const std::string& path, const RenderResult& result, const Labels& labels,
                 const RenderOptions& options, const Image& header);

/// How long write_image will take, as some rows of the picture show, s.
double seconds_to_write(const RenderResult& result, const Labels& labels,
                        const RenderOptions& options, const Image& header);

/// "64 samples a pixel", and " 440 nm S0 1.3 %, DoLP 0.0052; 600 nm …": standard errors (rms).
std::string samples_text(const Film& film);
std::string errors_text(const Film& film);

/// One line on standard output; refusals and an early end also in a quiet run, on stderr.
void tell_result(const RenderOptions& options, const RenderStats& stats,
                 const RenderResult& result);

}  // namespace malus::cli
