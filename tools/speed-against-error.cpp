// speed-against-error.cpp — error against seconds and rays, of several methods on several scenes.
//
// Error   deviation of S0 (relative) and DoLP from a reference, over the pixels that show a surface,
//         per wavelength and the worst of all: RMS, median and 95th percentile (error_curve.h).
//         Without attenuation the radiance of Priest-Germer paint grows as 1/cosθ toward grazing
//         views, and other surfaces see some of it so: single samples can outweigh a picture, and
//         the RMS has no limit to settle at. Percentiles have.
// Method  8, 16, 32, … samples a pixel (or a target error of like effect) while its budget lasts, all methods in turn, at least twice
//         with other seeds: errors of all rounds, seconds and rays of the fastest, since machines
//         are shared.
// Reference  quasi-Monte Carlo with another seed and as many samples as kReferenceBudget times that
//         budget allows. Its own error is that of its error bars. Curves end where they come
//         within kReach times of it.
// Writes  speed-against-error.csv, -summary.csv and .md into a folder; called by
//         tools/speed-against-error from the root of the checkout.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <thread>

#include "cli/validators.h"
#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/io/gltf.h"
#include "malus/io/material_file.h"
#include "malus/io/sky_file.h"
#include "malus/optics/wavelengths.h"
#include "malus/render/render.h"
#include "tools/benchmark_scenes.h"
#include "tools/error_curve.h"

using namespace malus;

namespace {

const std::vector<double> kWavelengths{440, 600};  // nm
constexpr double kReferenceBudget = 7, kReach = 3;
constexpr std::uint64_t kReferenceSeed = 1ull << 40;  // beyond those of the methods
constexpr int kUsage = 2;

struct Options {
    int width = 64, height = 48;
    double budget_s = 16;
    int threads = 0;
    bool quick = false;
    std::vector<std::string> scenes;  ///< names of subjects; empty: all
    std::filesystem::path folder = "out";
};

/// A way to the same picture: what `set` makes of the default settings to draw so many samples.
struct Method {
    const char* name;
    enum class Wavelengths { kTogether, kOneByOne } wavelengths;
    void (*set)(RenderSettings&, std::uint32_t samples);
};

const std::vector<Method> kMethods{
    {"plain Monte Carlo", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = samples;
         s.sampling = Sampling::kIndependent;
         s.sky_table = false;
     }},
    {"quasi-Monte Carlo", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = samples;
         s.sky_table = false;
     }},
    {"QMC light samples only", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = samples;
         s.lighting = Lighting::kLightSamples;
     }},
    {"QMC surface samples only", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = samples;
         s.lighting = Lighting::kSurfaceSamples;
     }},
    {"QMC one wavelength at a time", Method::Wavelengths::kOneByOne,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = samples;
         s.sky_table = false;
     }},
    {"QMC with the sky table", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) { s.spp = samples; }},
    // With the sky table, to about the error that so many samples in each pixel leave in 95 % of them.
    {"QMC to a target error", Method::Wavelengths::kTogether,
     [](RenderSettings& s, std::uint32_t samples) {
         s.spp = 1u << 20;
         s.target_error = 0.4 * std::pow(samples / 8.0, -0.6);
     }},
};
// Of the reference: that with the fewest tricks.
const Method& kReferenceMethod = kMethods[1];

/// What is rendered: a scene file, its paint if not by names, its view if not by a camera of its own; or a
/// scene made on the spot.
struct Subject {
    const char *name, *file;
    std::vector<PaintRule> paint;
    std::optional<View> view;
    BenchmarkScene (*make)(const std::vector<Material>& materials) = nullptr;
};

const std::vector<Subject> kSubjects{
    {"target_a", "scenes/target_a.glb", {}, {}},
    {"target_b", "scenes/target_b.glb", {}, {}},
    // Nothing but panel in the picture, seen from near: its margin is negative.
    {"panel",
     "scenes/panel.gltf",
     {{"*", "green_paint"}},
     View{to_radians(60), to_radians(30), to_radians(25), -1}},
    {"plain", "", {}, {}, plain_scene},
    {"relief", "", {}, {}, relief_scene},
    {"canyon", "", {}, {}, canyon_scene},
};

/// What all methods have of a subject.
struct Inputs {
    Scene scene;
    std::vector<int> paints;
    std::vector<Material> materials;
    Sky sky;
    Camera camera;

    PreparedScene prepared(std::vector<double> wavelengths_nm) const {
        return {scene, paints, materials, sky, std::move(wavelengths_nm)};
    }
};

Inputs read_inputs(const Subject& subject, const Options& options) {
    Inputs in;
    in.materials = read_materials("materials/paints.json").materials;
    in.sky = read_sky("skies/rayleigh_60.exr");
    if (subject.make) {
        BenchmarkScene made = subject.make(in.materials);
        in.scene = std::move(made.scene), in.paints = std::move(made.paints);
    } else {
        in.scene = read_gltf(subject.file);
        in.paints = assign_paints(in.scene, subject.paint, in.materials);
    }
    in.camera = subject.view
                    ? frame_view(*subject.view, bounds(in.scene), options.width, options.height)
                    : in.scene.cameras.at(0);
    return in;
}

/// Films of the same picture: one with all wavelengths or one for each.
struct Rendered {
    std::vector<Film> films;
    double seconds = 0, samples = 0;
    std::uint64_t rays = 0;
};

Rendered timed_render(const std::vector<PreparedScene>& scenes, const Camera& camera,
                      const RenderSettings& settings) {
    Rendered all;
    for (const PreparedScene& scene : scenes) {
        const auto start = std::chrono::steady_clock::now();
        RenderResult result = render(scene, camera, settings);
        all.seconds +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        all.rays += result.rays;
        for (std::uint32_t samples : result.film.samples)
            all.samples += samples / static_cast<double>(result.film.pixel_count()) /
                           static_cast<double>(scenes.size());
        all.films.push_back(std::move(result.film));
    }
    return all;
}

/// A line of the table: one method at one number of samples, or the reference.
struct Row {
    std::string method;
    double samples, seconds;
    std::uint64_t rays;
    std::vector<Errors> errors;  ///< one a wavelength, then the worst
};

/// What was measured of a subject; the first row is the reference.
struct Study {
    std::string name;
    std::vector<Row> rows;
    std::size_t unknown_pixels = 0;  ///< left out, since the reference knows nothing of them
};

/// A method while it is measured.
struct Contender {
    const Method* method;
    std::vector<PreparedScene> scenes;
    double left_s;  ///< of its budget
};

/// A method at one number of samples: errors of all rounds, seconds and rays of the fastest.
struct Tally {
    Row row;
    std::vector<Deviations> deviations;
    double spent_s = 0;
};

class Laboratory {
  public:
    Laboratory(const Subject& subject, const Options& options)
        : options_(options), in_(read_inputs(subject, options)), study_{subject.name, {}, 0} {}

    Study run() && {
        make_reference();
        std::vector<Contender> contenders;
        for (const Method& method : kMethods)
            contenders.push_back({&method, prepared_for(method), options_.budget_s});
        for (std::uint32_t samples = 8; !contenders.empty(); samples *= 2)
            measure(samples, contenders);
        return std::move(study_);
    }

  private:
    RenderSettings settings_for(const Method& method, std::uint32_t samples,
                                std::uint64_t seed) const {
        RenderSettings settings;
        settings.width = options_.width;
        settings.height = options_.height;
        settings.threads = options_.threads;
        settings.seed = seed;
        method.set(settings, samples);
        return settings;
    }

    std::vector<PreparedScene> prepared_for(const Method& method) const {
        std::vector<PreparedScene> scenes;
        if (method.wavelengths == Method::Wavelengths::kTogether)
            scenes.push_back(in_.prepared(kWavelengths));
        else
            for (double nm : kWavelengths) scenes.push_back(in_.prepared({nm}));
        return scenes;
    }

    void make_reference() {
        const std::vector<PreparedScene> scenes = prepared_for(kReferenceMethod);
        const auto rendered = [&](std::uint32_t samples) {
            return timed_render(scenes, in_.camera,
                                settings_for(kReferenceMethod, samples, kReferenceSeed));
        };
        constexpr std::uint32_t kTrial = 64;
        const double times = kReferenceBudget * options_.budget_s / rendered(kTrial).seconds;
        Rendered best = rendered(kTrial << static_cast<int>(std::log2(std::max(1.0, times))));
        reference_ = std::move(best.films.front());
        study_.unknown_pixels = unknown_pixels(reference_);
        Row row{"reference", best.samples, best.seconds, best.rays, {}};
        for (std::size_t w = 0; w < kWavelengths.size(); ++w)
            row.errors.push_back(summarize(expected_deviations(reference_, w)));
        add(std::move(row));
    }

    // All contenders in turn, so that what else the machine does slows all of them; those whose
    // budget does not last for twice the samples leave.
    void measure(std::uint32_t samples, std::vector<Contender>& contenders) {
        constexpr int kLeast = 2, kMost = 8;
        constexpr double kShort = 0.25;  // s
        std::vector<Tally> tallies;
        for (const Contender& contender : contenders)
            tallies.push_back({{contender.method->name, 0, HUGE_VAL, 0, {}},
                               std::vector<Deviations>(kWavelengths.size())});
        for (int round = 0; round < kMost; ++round)
            for (std::size_t i = 0; i < contenders.size(); ++i)
                if (round < kLeast || tallies[i].spent_s < kShort)
                    render_once(contenders[i], samples,
                                samples * kMost + static_cast<std::uint64_t>(round), tallies[i]);
        std::vector<Contender> lasting;
        for (std::size_t i = 0; i < contenders.size(); ++i) {
            contenders[i].left_s -= tallies[i].spent_s;
            if (2 * kLeast * tallies[i].row.seconds <= contenders[i].left_s)
                lasting.push_back(std::move(contenders[i]));
            for (Deviations& each : tallies[i].deviations)
                tallies[i].row.errors.push_back(summarize(std::move(each)));
            add(std::move(tallies[i].row));
        }
        contenders = std::move(lasting);
    }

    void render_once(const Contender& contender, std::uint32_t samples, std::uint64_t seed,
                     Tally& tally) const {
        const Rendered rendered = timed_render(contender.scenes, in_.camera,
                                               settings_for(*contender.method, samples, seed));
        tally.spent_s += rendered.seconds;
        std::size_t nm = 0;
        for (const Film& film : rendered.films)
            for (std::size_t w = 0; w < film.wavelengths_nm.size(); ++w)
                add_deviations(film, w, reference_, tally.deviations[nm++]);
        if (rendered.seconds > tally.row.seconds) return;
        tally.row.samples = rendered.samples, tally.row.seconds = rendered.seconds;
        tally.row.rays = rendered.rays;
    }

    void add(Row row) {
        row.errors.push_back(worst(row.errors));
        std::printf("%s, %s: %g samples a pixel, %.3g s, worst error of S0 %.2g %%, DoLP %.2g\n",
                    study_.name.c_str(), row.method.c_str(), row.samples, row.seconds,
                    100 * row.errors.back()[0], row.errors.back()[3]);
        std::fflush(stdout);
        study_.rows.push_back(std::move(row));
    }

    const Options& options_;
    Inputs in_;
    Film reference_;
    Study study_;
};

/// "440", "600", "worst".
std::string column(std::size_t nm) {
    return nm < kWavelengths.size() ? to_text(kWavelengths[nm]) : "worst";
}

template <class... Numbers>
std::string text(const char* format, Numbers... numbers) {
    char line[256];
    std::snprintf(line, sizeof line, format, numbers...);
    return line;
}

std::string table(const std::vector<Study>& studies) {
    std::string csv = "scene,method,samples,seconds,rays";
    for (std::size_t nm = 0; nm <= kWavelengths.size(); ++nm)
        for (const char* measure : kMeasures) csv += "," + std::string(measure) + "_" + column(nm);
    for (const Study& study : studies)
        for (const Row& row : study.rows) {
            csv += "\n" + study.name + "," + row.method +
                   text(",%g,%.5g,%llu", row.samples, row.seconds,
                        static_cast<unsigned long long>(row.rays));
            for (const Errors& errors : row.errors)
                for (double error : errors) csv += text(",%.4g", error);
        }
    return csv + "\n";
}

/// One measure of one method at one wavelength.
struct Verdict {
    ErrorCurve curve;  ///< as far as the reference tells
    std::optional<Slope> against_samples, against_seconds;
    std::vector<TimeTo> times;
};

// 1, 0.3, 0.1 and 0.01 %, in DoLP 0.01, 0.003, 0.001 and 0.0001.
constexpr std::array<double, 4> kGoals{1e-2, 3e-3, 1e-3, 1e-4};

Verdict judge(const Study& study, const Method& method, std::size_t nm, std::size_t measure) {
    ErrorCurve curve;
    for (const Row& row : study.rows)
        if (row.method == method.name)
            curve.push_back({row.samples, row.seconds, row.errors[nm][measure]});
    Verdict verdict{cut_below(curve, kReach * study.rows.front().errors[nm][measure]), {}, {}, {}};
    verdict.against_samples = slope(verdict.curve, &CurvePoint::samples);
    verdict.against_seconds = slope(verdict.curve, &CurvePoint::seconds);
    for (double goal : kGoals) verdict.times.push_back(time_to(verdict.curve, goal));
    return verdict;
}

std::string slope_text(const std::optional<Slope>& slope) {
    return slope ? text("%.2f ± %.2f", slope->value, slope->error) : "";
}

std::string time_text(const TimeTo& time) {
    switch (time.kind) {
        case TimeTo::Kind::kSooner:
            return text("<%.2g", time.seconds);
        case TimeTo::Kind::kMeasured:
            return text("%.3g", time.seconds);
        case TimeTo::Kind::kExtrapolated:
            return text("~%.2g", time.seconds);
        case TimeTo::Kind::kUnknown:
            break;
    }
    return "";
}

std::string summary_line(const Study& study, const Method& method, std::size_t nm,
                         std::size_t measure) {
    const Verdict verdict = judge(study, method, nm, measure);
    std::string line =
        study.name + "," + method.name + "," + kMeasures[measure] + "," + column(nm) +
        text(",%zu,%.4g", verdict.curve.size(), study.rows.front().errors[nm][measure]);
    for (const auto& fit : {verdict.against_samples, verdict.against_seconds})
        line += fit ? text(",%.3f,%.3f", fit->value, fit->error) : ",,";
    if (verdict.curve.empty()) {
        line += ",,,";
    } else {
        const CurvePoint& last = verdict.curve.back();
        line += text(",%.4g,%.4g,%.4g", last.seconds, last.error, figure_of_merit(last));
    }
    for (const TimeTo& time : verdict.times) line += "," + time_text(time);
    return line;
}

std::string summary(const std::vector<Study>& studies) {
    std::string csv =
        "scene,method,measure,wavelength,points,reference_error,slope_samples,"
        "slope_samples_error,slope_seconds,slope_seconds_error,last_seconds,last_error,"
        "figure_of_merit";
    for (double goal : kGoals) csv += text(",seconds_to_%g", goal);
    for (const Study& study : studies)
        for (const Method& method : kMethods)
            for (std::size_t nm = 0; nm <= kWavelengths.size(); ++nm)
                for (std::size_t m = 0; m < kMeasures.size(); ++m)
                    csv += "\n" + summary_line(study, method, nm, m);
    return csv + "\n";
}

// How far the smallest error measured is above the reference's own.
double least_ratio(const Study& study, std::size_t measure) {
    double least = HUGE_VAL;
    for (std::size_t i = 1; i < study.rows.size(); ++i)
        least = std::min(least, study.rows[i].errors.back()[measure]);
    return least / study.rows.front().errors.back()[measure];
}

std::string report(const Study& study, const Options& options) {
    const Row& reference = study.rows.front();
    std::string md = text(
        "## %s\n\n%d x %d pixels, %zu of them left out; %d threads. Reference: %g samples a "
        "pixel, %.0f s;",
        study.name.c_str(), options.width, options.height, study.unknown_pixels, options.threads,
        reference.samples, reference.seconds);
    md += " its own error, and how many times smaller that is than the smallest measured: ";
    for (std::size_t m = 0; m < kMeasures.size(); ++m)
        md += text("%s%s %.1e (%.1f)", m ? ", " : "", kMeasures[m], reference.errors.back()[m],
                   least_ratio(study, m));
    md +=
        ".\n\n| method | error | slope against samples | against seconds | last "
        "point: s | error | 1/(σ²T), 1/s | s to 0.01 | 0.003 | 0.001 | 0.0001 "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (std::size_t m = 0; m < kMeasures.size(); ++m)
        for (const Method& method : kMethods) {
            const Verdict verdict = judge(study, method, kWavelengths.size(), m);
            md += text("| %s | %s |", method.name, kMeasures[m]);
            if (verdict.curve.empty()) {
                md += " | | | | |";
            } else {
                const CurvePoint& last = verdict.curve.back();
                md += text(" %s | %s | %.2g | %.2g | %.2g |",
                           slope_text(verdict.against_samples).c_str(),
                           slope_text(verdict.against_seconds).c_str(), last.seconds, last.error,
                           figure_of_merit(last));
            }
            for (const TimeTo& time : verdict.times) md += " " + time_text(time) + " |";
            md += "\n";
        }
    return md + "\n";
}

void write_all(const std::vector<Study>& studies, const Options& options) {
    write_text(options.folder / "speed-against-error.csv", table(studies));
    write_text(options.folder / "speed-against-error-summary.csv", summary(studies));
    std::string md =
        "# Error against time\n\n"
        "S0 relative, DoLP absolute, of the worse wavelength. `~`: beyond the last point, by the "
        "slope; `<`: sooner than the first; empty: the error does not fall, or too few points are "
        "above " +
        text("%g", kReach) +
        " times the reference's own error. Left out: pixels of which the reference knows nothing, "
        "since one sample carries all of their light.\n\n";
    for (const Study& study : studies) md += report(study, options);
    write_text(options.folder / "speed-against-error.md", md);
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw Error(folder.string() + ": cannot be made a folder (" + error.message() +
                    "); choose another --output");
}

void run(Options options) {
    if (options.threads == 0)
        options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    make_folder(options.folder);
    check_writable(options.folder / "speed-against-error.csv");
    std::vector<Study> studies;
    for (const Subject& subject : kSubjects) {
        if (!options.scenes.empty() &&
            !std::count(options.scenes.begin(), options.scenes.end(), subject.name))
            continue;
        studies.push_back(Laboratory(subject, options).run());
        write_all(studies, options);
    }
    std::printf("wrote %s: speed-against-error.csv, -summary.csv, .md\n",
                options.folder.string().c_str());
}

void parse_and_run(int argc, char** argv) {
    Options options;
    CLI::App app{
        "Measure error against seconds and rays: several methods on shipped scenes and on some "
        "made on the spot, beside a reference that is converged far beyond.",
        "speed-against-error"};
    CLI::Option* width = app.add_option("--width", options.width, "Columns, pixels");
    CLI::Option* height = app.add_option("--height", options.height, "Rows, pixels");
    CLI::Option* budget =
        app.add_option("--budget", options.budget_s,
                       "Seconds for each method on each scene; a scene's reference takes " +
                           text("%g", kReferenceBudget) + " times as much");
    width->check(CLI::Range(1, 4096))->capture_default_str();
    height->check(CLI::Range(1, 4096))->capture_default_str();
    budget->check(cli::within(0.1, 1e6))->capture_default_str();
    app.add_option("--threads", options.threads, "Threads; 0: all of the machine")
        ->check(CLI::Range(0, 4096));
    std::vector<std::string> names;
    for (const Subject& subject : kSubjects) names.push_back(subject.name);
    app.add_option("--scenes", options.scenes,
                   "Which scenes, with commas between; all where not given")
        ->delimiter(',')
        ->check(CLI::IsMember(names));
    app.add_option("-o,--output", options.folder, "Folder for tables and pictures")
        ->capture_default_str();
    app.add_flag("--quick", options.quick,
                 "32 x 24 pixels and a budget of 1.5 s, where they are not given");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp& help) {
        app.exit(help);
        return;
    }
    if (options.quick) {
        if (width->empty()) options.width = 32;
        if (height->empty()) options.height = 24;
        if (budget->empty()) options.budget_s = 1.5;
    }
    run(options);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        parse_and_run(argc, argv);
    } catch (const CLI::ParseError& usage) {
        std::fprintf(stderr, "speed-against-error: %s; see --help\n",
                     one_line(usage.what()).c_str());
        return kUsage;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "speed-against-error: %s\n", one_line(error.what()).c_str());
        return 1;
    }
    return 0;
}
