// commands.h — the commands of the program, each in a file of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace malus::cli {

void add_render(CLI::App& app, const std::string& command_line);
void add_sky(CLI::App& app, const std::string& command_line);
void add_sky_info(CLI::App& sky);
void add_sky_import(CLI::App& sky, const std::string& command_line);
void add_materials(CLI::App& app);
void add_preview(CLI::App& app);
void add_info(CLI::App& app);
void add_brdf(CLI::App& app, const std::string& command_line);
void add_merge(CLI::App& app, const std::string& command_line);
void add_report(CLI::App& app);
void add_hist(CLI::App& app);
void add_detect(CLI::App& app);

/// Sets `exit_code` to kDifference when images differ.
void add_compare(CLI::App& app, int& exit_code);
inline constexpr int kDifference = 3;

/// Replaces this process by malus-preview, which stands beside malus or on the PATH; argv[0] is
/// "preview". Throws Error if it cannot be found.
[[noreturn]] void run_preview(int argc, char** argv);

/// Of --compress.
inline constexpr const char* kCompressHelp =
    "Write the image with ZIP compression: up to a fifth smaller, since the last digits of its "
    "numbers are noise, and ten to thirty times slower to write";

/// The values of --wavelengths, ascending. Throws Error for one that stands twice.
std::vector<double> sorted_wavelengths(std::vector<double> wavelengths_nm);

std::string version();
/// The command line as one line, quoted where a shell would need it.
std::string command_line(int argc, char** argv);

}  // namespace malus::cli
