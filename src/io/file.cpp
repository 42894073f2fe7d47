// file.cpp — reading whole files, writing beside and renaming.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "malus/core/error.h"

namespace fs = std::filesystem;

namespace malus {
namespace {

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

void check_writable(const fs::path& path) {
    std::error_code error;
    const fs::path folder = folder_of(path);
    if (!fs::is_directory(folder, error))
        throw Error(path.string() + ": cannot be written (there is no folder '" + folder.string() +
                    "'); create it or choose another name");
    if (fs::is_directory(path, error))
        throw Error(path.string() + ": cannot be written (it is a folder); add a file name");
    if (fs::exists(path, error) && !fs::is_regular_file(path, error))
        throw Error(path.string() +
                    ": cannot be written (it is a device or a pipe, which a finished file would "
                    "replace); name a file");
    if (::access(folder.c_str(), W_OK) != 0)
        throw Error(path.string() + ": cannot be written (" + std::strerror(errno) +
                    "); choose a folder that you may write to");
}

void check_distinct(const fs::path& output, const std::vector<fs::path>& others) {
    std::error_code error;
    const fs::path place = fs::weakly_canonical(output, error);
    for (const fs::path& other : others)
        if (!other.empty() && fs::weakly_canonical(other, error) == place)
            throw Error(output.string() + ": would replace '" + other.string() +
                        "', which this command also uses; choose another name");
}

void check_outputs(const std::vector<fs::path>& inputs,
                   std::initializer_list<std::string> outputs) {
    std::vector<fs::path> taken = inputs;
    for (const std::string& output : outputs) {
        if (output.empty()) continue;
        check_writable(output);
        check_distinct(output, taken);
        taken.push_back(output);
    }
}

void write_whole(const fs::path& path, const std::function<void(const fs::path&)>& write) {
    check_writable(path);
    // A link stays a link: what it points to is replaced.
    std::error_code ignored;
    const fs::path target = fs::is_symlink(path, ignored) ? fs::canonical(path, ignored) : path;
    const fs::path beside = folder_of(target) / (".malus-" + std::to_string(::getpid()) + "-" +
                                                 target.filename().string());
    try {
        write(beside);
        fs::rename(beside, target);
    } catch (const std::exception& problem) {
        fs::remove(beside, ignored);
        throw Error(path.string() + ": cannot be written (" + one_line(problem.what()) +
                    "); check the space that is left and the rights of the folder");
    }
}

std::string read_text(const fs::path& path) {
    std::error_code error;
    const auto status = fs::status(path, error);
    if (!fs::exists(status)) throw Error(path.string() + ": file not found; check the name");
    if (!fs::is_regular_file(status))
        throw Error(path.string() + ": not a regular file; name a file");
    constexpr std::uintmax_t kMost = std::uintmax_t{1} << 30;
    if (fs::file_size(path, error) > kMost)
        throw Error(path.string() + ": larger than 1 GiB; this cannot be what is meant");
    std::ifstream in(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    if (!in.good() && !in.eof())
        throw Error(path.string() + ": cannot be read; check the rights of the file");
    return text;
}

void write_text(const fs::path& path, const std::string& text) {
    write_whole(path, [&](const fs::path& beside) {
        std::ofstream out(beside, std::ios::binary);
        out << text;
        out.close();
        if (!out) throw Error("writing failed");
    });
}

}  // namespace malus
