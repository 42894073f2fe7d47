// main.cpp — malus: one command a file in cli/; errors become one line and an exit code here.
//
// Exit    0 done; 1 an input or the run failed; 2 wrong usage; 3 compare found a difference.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <new>

#include "cli/commands.h"
#include "malus/core/error.h"

namespace {

constexpr int kFailed = 1, kUsage = 2;

// The commands that are called, e.g. {"sky", "make"}: words on the line that name one.
std::vector<std::string> called(const CLI::App& app, int argc, char** argv) {
    std::vector<std::string> commands;
    const CLI::App* at = &app;
    for (int i = 1; i < argc; ++i) {
        const auto subs =
            at->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == argv[i]; });
        if (subs.empty()) continue;
        at = subs.front();
        commands.push_back(argv[i]);
    }
    return commands;
}

// Of all commands.
std::vector<std::string> names_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* sub : app.get_subcommands(nullptr)) names.push_back(sub->get_name());
    return names;
}

// Config files: the options of the command that is called, at the top of the file or in a section
// of the command's name.
class CommandConfig : public CLI::ConfigTOML {
  public:
    explicit CommandConfig(std::vector<std::string> command) : command_(std::move(command)) {}
    std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
        std::vector<CLI::ConfigItem> found = CLI::ConfigTOML::from_config(in);
        for (CLI::ConfigItem& item : found)
            if (item.parents.empty() && item.name != "++" && item.name != "--")
                item.parents = command_;
        return found;
    }

  private:
    std::vector<std::string> command_;
};

int run(int argc, char** argv) {
    CLI::App app{
        "malus: renders what a polarimetric imager sees of a glTF scene under a polarized "
        "sky, and how far each number can be trusted.",
        "malus"};
    app.require_subcommand(1);
    app.fallthrough();
    app.set_version_flag("--version", malus::cli::version());
    app.set_config("--config", "", "Take options from this TOML file (same names, without --)");
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.footer("malus COMMAND --help explains the options of a command with units and defaults.");
    malus::cli::add_render(app, malus::cli::command_line(argc, argv));
    malus::cli::add_sky(app, malus::cli::command_line(argc, argv));
    malus::cli::add_materials(app);
    malus::cli::add_brdf(app, malus::cli::command_line(argc, argv));
    malus::cli::add_preview(app);
    malus::cli::add_info(app);
    malus::cli::add_merge(app, malus::cli::command_line(argc, argv));
    malus::cli::add_report(app);
    malus::cli::add_hist(app);
    malus::cli::add_detect(app);
    int exit_code = 0;
    malus::cli::add_compare(app, exit_code);
    const std::vector<std::string> commands = called(app, argc, argv);
    app.config_formatter(std::make_shared<CommandConfig>(commands));
    if (commands.empty() && argc > 1 && argv[1][0] != '-') {
        std::cerr << "malus: unknown command '" << malus::one_line(argv[1]) << "'"
                  << malus::suggest(argv[1], names_of(app)) << '\n';
        return kUsage;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ConfigError& problem) {
        // CLI11 calls every such file an INI file.
        std::string what = problem.what();
        const std::string theirs = "INI was not able to parse ";
        if (what.starts_with(theirs))
            what = "no option of this name: " + what.substr(theirs.size());
        std::cerr << "malus: --config: " << malus::one_line(what) << '\n';
        return kUsage;
    } catch (const CLI::ParseError& usage) {
        return app.exit(usage) == 0 ? 0 : kUsage;
    }
    return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        // The preview program reads its own options, --help included.
        if (argc > 1 && std::strcmp(argv[1], "preview") == 0)
            malus::cli::run_preview(argc - 1, argv + 1);
        const int code = run(argc, argv);
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            throw malus::Error("standard output: not written in full (" +
                               std::string(std::strerror(errno)) +
                               "); free space there, or write elsewhere");
        return code;
    } catch (const malus::Error& error) {
        std::cerr << "malus: " << error.what() << '\n';
    } catch (const std::bad_alloc&) {
        std::cerr << "malus: not enough memory for this; render fewer pixels or wavelengths\n";
    } catch (const std::exception& error) {
        std::cerr << "malus: " << malus::one_line(error.what()) << '\n';
    }
    return kFailed;
}
