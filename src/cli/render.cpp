// render.cpp — malus render: from files to an image with error bars.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <thread>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/provenance.h"
#include "cli/render_output.h"
#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/exposure_file.h"
#include "malus/io/file.h"

namespace malus::cli {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// The cap of a render that stops by its error or the clock.
constexpr std::uint32_t kMostSamples = 1u << 20;

// `--materials a.json scene.glb` gives the scene to --materials, which takes any number of files.
void find_scene(RenderOptions& options) {
    if (!options.scene.empty()) return;
    const std::string last = options.materials.back();
    if (options.materials.size() < 2 || !(last.ends_with(".gltf") || last.ends_with(".glb")))
        throw CLI::RequiredError("scene");
    options.scene = last;
    options.materials.pop_back();
}

// Outputs can be written and replace nothing that is read or written besides; only what --resume
// goes on from may be replaced by what becomes of it.
void check_outputs(RenderOptions& options) {
    if (options.output.empty()) options.output = options.resume;
    if (options.output.empty()) throw CLI::RequiredError("--output");
    std::vector<std::filesystem::path> others(options.materials.begin(), options.materials.end());
    others.insert(others.end(), {options.scene, options.sky});
    check_exr_name(options.output);
    check_writable(options.output);
    check_distinct(options.output, others);
    if (!options.final) {
        check_writable(sums_path(options.output));
        check_distinct(sums_path(options.output), others);
    }
    if (options.stats.empty()) return;
    others.insert(others.end(), {options.output, options.resume, sums_path(options.output),
                                 sums_path(options.resume)});
    check_writable(options.stats);
    check_distinct(options.stats, others);
}

// The settings as they will be carried out.
RenderSettings final_settings(const RenderOptions& options) {
    RenderSettings settings = options.settings;
    const bool adaptive = settings.target_error > 0 || options.time_limit_s > 0;
    if (adaptive && options.spp_option->empty()) settings.spp = kMostSamples;
    const std::uint32_t asked = settings.spp;
    settings.spp = whole_spp(asked, settings.replicates);
    if (settings.spp != asked)
        warn(options, "--spp " + std::to_string(asked) + " is taken as " +
                          std::to_string(settings.spp) + ", as many for each of the " +
                          std::to_string(settings.replicates) +
                          " replicates that give the error bars");
    if (settings.threads == 0)
        settings.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    catch_interrupts();
    settings.stop = &interrupted();
    return settings;
}

// What --resume goes on from; empty without it.
Exposure begun(const RenderOptions& options, const Scene& scene, const Image& header,
               const RenderSettings& settings) {
    if (options.resume.empty()) return {};
    const std::string place = options.resume + ": --resume: ";
    const Image other = read_exr_header(options.resume);
    if (const std::string what = first_difference(header, other); !what.empty())
        throw Error(place + "it is of " + what + "; give what it was rendered with");
    const std::string* sums = other.text("sumsHash");
    if (!sums)
        throw Error(place +
                    "it has no sums to go on from (rendered with --final, or merged); render "
                    "it anew");
    const auto table = other.attributes.find("skyTable");
    if (table == other.attributes.end() || table->second != header.attributes.at("skyTable"))
        throw Error(place + "it was rendered " + (settings.sky_table ? "with" : "without") +
                    " --no-sky-table; do so again");
    const std::string* seed = other.text("seed");
    if (!seed || *seed != *header.text("seed"))
        throw Error(place + "it has seed " + (seed ? *seed : "none") +
                    "; give --seed with that, or merge renders of different seeds");
    Exposure exposure = read_exposure(sums_path(options.resume));
    if (fingerprint(exposure) != *sums)
        throw Error(place + "the sums in " + sums_path(options.resume).string() +
                    " are of another render; render it anew");
    const auto instances = static_cast<std::int32_t>(scene.instances.size());
    for (std::int32_t instance : exposure.instance)
        if (instance >= instances)
            throw Error(place + "the sums in " + sums_path(options.resume).string() +
                        " name what is not in the scene; render it anew");
    if (exposure.replicates != settings.replicates)
        throw Error(place + "it has " + std::to_string(exposure.replicates) +
                    " replicates; give --replicates with that");
    const std::uint32_t least = *std::min_element(exposure.taken.begin(), exposure.taken.end());
    if (least * settings.replicates >= settings.spp)
        throw Error(place + "each pixel has " + std::to_string(least * settings.replicates) +
                    " samples or more; ask for more by --spp");
    return exposure;
}

// Renders with a line of progress. A time limit is of the whole command: the first samples of each
// pixel come first, and show what writing will take.
class Run {
  public:
    Run(const RenderOptions& options, const Inputs& inputs, const PreparedScene& scene,
        const Image& header)
        : options_(options), inputs_(inputs), scene_(scene), header_(header) {}

    RenderResult go_on(Exposure exposure, RenderSettings settings, Clock::time_point start) {
        if (!(options_.time_limit_s > 0)) return step(std::move(exposure), settings);
        RenderSettings first = settings;
        first.spp = settings.replicates;
        first.target_error = 0;
        RenderResult result = step(std::move(exposure), first);
        if (result.stopped_by == StoppedBy::kRequest) return result;
        const double writing = seconds_to_write(result, inputs_.labels, options_, header_);
        settings.time_limit_s =
            std::max(1e-3, options_.time_limit_s - seconds_since(start) - writing);
        RenderResult rest = step(std::move(result.exposure), settings);
        rest.paths += result.paths, rest.rays += result.rays, rest.refused += result.refused;
        if (rest.first_refused.empty()) rest.first_refused = result.first_refused;
        return rest;
    }

  private:
    RenderResult step(Exposure exposure, RenderSettings settings) {
        Progress progress("rendering", options_.quiet);
        settings.progress = [&](double done) { progress.update(done); };
        return render(scene_, inputs_.camera, settings, std::move(exposure));
    }

    const RenderOptions& options_;
    const Inputs& inputs_;
    const PreparedScene& scene_;
    const Image& header_;
};

void render_to_file(RenderOptions& options, const std::string& command_line) {
    RenderStats stats;
    const auto start = Clock::now();
    find_scene(options);
    check_outputs(options);
    Inputs in = read_inputs(options);
    const RenderSettings settings = final_settings(options);
    Image header = make_header(options, in, settings, command_line);
    Exposure exposure = begun(options, in.scene, header, settings);
    stats.load_s = seconds_since(start);

    auto last = Clock::now();
    const PreparedScene prepared(std::move(in.scene), in.paints, in.materials, in.sky,
                                 in.wavelengths_nm);
    stats.build_s = seconds_since(last);
    stats.sky = prepared.sky_resampling();

    last = Clock::now();
    RenderResult result =
        Run(options, in, prepared, header).go_on(std::move(exposure), settings, start);
    stats.render_s = seconds_since(last);
    if (!result.complete())
        throw Error(options.output +
                    ": not written (stopped by a signal before each pixel had its first samples)");

    stats.version = version();
    stats.scene = options.scene;
    stats.spp = settings.spp;
    stats.target_error = settings.target_error;
    stats.time_limit_s = options.time_limit_s;
    stats.max_depth = settings.max_depth;
    stats.threads = settings.threads;
    stats.seed = settings.seed;
    last = Clock::now();
    header.attributes["skyGridCells"] = static_cast<int>(stats.sky.cells);
    header.attributes["wallTime"] = static_cast<float>(seconds_since(start));
    // Without the sums there is memory for the file, which the system need not find first.
    if (options.final) result.exposure = Exposure(0, 0, {}, result.exposure.replicates);
    write_image(options.output, result, in.labels, options, header);
    stats.write_s = seconds_since(last);
    if (!options.stats.empty()) write_stats(options.stats, stats, result);
    tell_result(options, stats, result);
}

void add_inputs(CLI::App& sub, RenderOptions& o) {
    sub.add_option("scene", o.scene, "Scene, glTF 2.0: .gltf or .glb (required)");
    sub.add_option("--sky", o.sky, "Sky map: .exr (malus sky make) or .csv")->required();
    sub.add_flag("--no-sun", o.no_sun,
                 "Leave out the sun's disc, which lights the scene where the sky map declares one "
                 "(sunIrradiance)");
    sub.add_option("--materials", o.materials, "Paints: one or more .json files")->required();
    sub.add_option("-o,--output", o.output,
                   "Image to write, EXR (required; with --resume by default that file)");
    sub.add_option("--stats", o.stats, "Write what was done to this JSON file");
    sub.add_option("--wavelengths", o.wavelengths_nm,
                   "Wavelengths, nm, e.g. 440,600 [all of the sky that the materials cover]")
        ->delimiter(',')
        ->allow_extra_args(false);
    sub.add_option("--assign", o.assign,
                   "Give a glTF node, mesh or material (by name; * for the rest) a paint: "
                   "NAME=MATERIAL; repeatable [the paint named like the glTF material]")
        ->take_all()
        ->expected(1)
        ->allow_extra_args(false);
}

void add_view(CLI::App& sub, RenderOptions& o) {
    const std::string group = "View";
    o.camera_option =
        sub.add_option("--camera", o.camera,
                       "A camera of the scene, by name [the first, unless an option below asks for "
                       "another view]")
            ->group(group);
    o.view_options = {
        sub.add_option("--view-zenith", o.view_zenith_deg,
                       "Zenith angle of the detector as seen from the target, degrees")
            ->check(within(0.0, 180.0)),
        sub.add_option("--view-azimuth", o.view_azimuth_deg,
                       "Azimuth of the detector as seen from the target, degrees clockwise from "
                       "north (-Z); image up is away from the ground, north when looking straight "
                       "down")
            ->check(within(-360.0, 360.0)),
        sub.add_option("--look-at", o.look_at, "Frame this node instead of the whole scene"),
        sub.add_option("--fov", o.fov_deg,
                       "Perspective with this vertical field of view, degrees [orthographic]")
            ->check(within(1e-3, 170.0)),
        sub.add_flag("--orthographic", o.orthographic,
                     "Orthographic view (the default of these views)"),
        sub.add_option("--margin", o.margin, "Free border, fraction of the picture")
            ->check(within(0.0, 0.45))};
    for (CLI::Option* option : o.view_options) {
        option->group(group)->excludes(o.camera_option);
        if (option->get_name() != "--look-at" && option->get_name() != "--fov" &&
            option->get_name() != "--orthographic")
            option->capture_default_str();
    }
    o.view_options[4]->excludes(o.view_options[3]);
}

void add_sampling(CLI::App& sub, RenderOptions& o) {
    RenderSettings& s = o.settings;
    sub.add_option("--width", s.width, "Columns, pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    sub.add_option("--height", s.height, "Rows, pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    o.spp_option =
        sub.add_option("--spp", s.spp,
                       "Samples a pixel, rounded up to as many of each replicate (beyond "
                       "64 of each to one of 32 steps in a doubling); with "
                       "--target-error or --time-limit the most, by default 1048576")
            ->check(CLI::Range(1u, 1u << 23))
            ->capture_default_str();
    sub.add_option("--max-depth", s.max_depth,
                   "Surface reflections on a path: 1 = sky light only, 2 = target-background too")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    sub.add_option("--seed", s.seed, "Another seed gives an independent image")
        ->check(within(0, 18446744073709549568.0))
        ->capture_default_str();
    sub.add_option("--threads", s.threads,
                   "Threads; 0: all of the machine. The image does not depend on it")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    sub.add_flag(
        "!--no-sky-table", s.sky_table,
        "Trace all of the sky's light, instead of what occluders change of the open sky's");
    sub.add_option("--replicates", s.replicates,
                   "Independent scrambles a pixel, whose spread is the error bar")
        ->check(CLI::Range(4u, 256u))
        ->capture_default_str();
    sub.add_option(
           "--target-error", s.target_error,
           "Stop when this error is reached: the standard error of DoLP is at most E and that "
           "of S0 at most E S0, at each wavelength, in 95 % of the pixels that show a "
           "surface, e.g. 0.01. Samples go where the error is")
        ->check(within(1e-6, 1.0));
    sub.add_option(
           "--time-limit", o.time_limit_s,
           "Stop after so many seconds, reading and writing included, with the smallest such "
           "error they can buy")
        ->check(within(1e-3, 1e9));
    sub.add_option("--resume", o.resume,
                   "Add samples to this image of the same scene and options, as if its render had "
                   "never stopped (--spp, --target-error: of all its samples together)");
    sub.add_flag("--final", o.final,
                 "Do not write OUT.exr.sums, the sums of samples beside the image that --resume "
                 "needs (20 bytes a pixel, wavelength and replicate)");
    sub.add_flag("--compress", o.compress, kCompressHelp);
    sub.add_flag("--debias", o.debias,
                 "Take from each pixel's DoLP what noise adds to it on average (MAS estimate, "
                 "Plaszczynski et al. 2014); the Stokes vector stays as it is. Average Stokes "
                 "vectors, never such DoLPs");
    sub.add_flag("--quiet", o.quiet, "No progress, no notes, no closing line");
}

}  // namespace

void add_render(CLI::App& app, const std::string& command_line) {
    CLI::App* sub = app.add_subcommand(
        "render",
        "Render a scene under a sky to a spectral EXR: S0..S3, DoLP, AoLP (degrees from image "
        "right, counter-clockwise) and their standard errors per pixel and wavelength");
    const auto options = std::make_shared<RenderOptions>();
    add_inputs(*sub, *options);
    add_view(*sub, *options);
    add_sampling(*sub, *options);
    sub->callback([options, command_line] { render_to_file(*options, command_line); });
}

}  // namespace malus::cli
