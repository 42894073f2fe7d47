// preview.cpp — hands `malus preview …` to the program malus-preview, the way git runs git-*.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "cli/commands.h"
#include "malus/core/error.h"

namespace malus::cli {

void add_preview(CLI::App& app) {
    // Only for the list of commands: main() runs the other program before options are read.
    app.add_subcommand("preview", "Make PNG pictures of an image or sky map: S0, DoLP, AoLP");
}

void run_preview(int argc, char** argv) {
    std::string name = "malus-preview";
    std::vector<char*> arguments(argv, argv + argc);
    arguments[0] = name.data();
    arguments.push_back(nullptr);
    std::error_code error;
    const auto beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / name;
    if (!error) ::execv(beside.c_str(), arguments.data());
    ::execvp(name.c_str(), arguments.data());
    throw Error("preview: cannot run the program malus-preview (" +
                std::string(std::strerror(errno)) + "); build or install it beside malus");
}

}  // namespace malus::cli
