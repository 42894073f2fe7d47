# study.py — renders, measures and writes the page of tools/reproduce-study.
#
# Experiments  target A and B × green and black paint, 440 and 600 nm in one pass, detector at zenith 30°,
#              azimuth 0°, Gaussian slopes, black ground; each four times with other random numbers.
# Distances    between histograms of the target's pixels (50 bins from 0 to the larger 99.9th percentile):
#              overlap Σ min(p, q), Hellinger's √(1 − Σ√(pq)); ± is the standard error over the four
#              pairs of renders. "Noise" is the same between two renders of one experiment.
# Told apart   where two histograms overlap by less than one half in every case.
# SPDX-License-Identifier: Apache-2.0
import base64
import html
import itertools
import json
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import OpenImageIO as oiio

FOLDER = Path(sys.argv[1])
MALUS = "build/release/malus"
PAINTS = "materials/paints.json"
SKY = "skies/rayleigh_60.exr"
TARGETS, COLOURS, WAVELENGTHS, SEEDS = ("a", "b"), ("green", "black"), (440, 600), range(4)
QUANTITIES = ("S0", "DoLP")
BINS = 50


def malus(*arguments):
    subprocess.run([MALUS, *map(str, arguments)], check=True, stdout=subprocess.PIPE)


def name_of(target, colour):
    return f"target_{target}_{colour}"


def experiments():
    return list(itertools.product(TARGETS, COLOURS))


def render_all():
    renders = FOLDER / "renders"
    renders.mkdir(exist_ok=True)
    for target, colour in experiments():
        name, images = name_of(target, colour), []
        for seed in SEEDS:
            images.append(renders / f"{name}_{seed}.exr")
            malus("render", f"scenes/target_{target}.glb", "--sky", SKY, "--materials", PAINTS,
                  "--assign", f"target={colour}_paint", "--wavelengths", "440,600",
                  "--view-zenith", 30, "--view-azimuth", 0, "--look-at", "target",
                  "--width", 320, "--height", 240, "--spp", 64, "--seed", seed, "--final",
                  "--quiet", "-o", images[-1])
        malus("merge", *images, "--quiet", "-o", FOLDER / f"{name}.exr")
        print(f"reproduce-study: {name}.exr", flush=True)


class Histograms:
    """Shares of the target's pixels, by (target, colour, seed, wavelength, quantity)."""

    def __init__(self):
        self.images = [(t, c, s) for t, c in experiments() for s in SEEDS]
        self.known = {}

    def count(self, quantity, nm, top, bins=BINS):
        output = FOLDER / "renders/hist.json"
        malus("hist", *(FOLDER / f"renders/{name_of(t, c)}_{s}.exr" for t, c, s in self.images),
              "--quantity", quantity, "--wavelengths", nm, "--node", "target", "--bins", bins,
              *(("--range", f"0,{float(top)!r}") if top else ()), "--json", output, "--quiet")
        return json.loads(output.read_text())["histograms"][0]

    def top(self, quantity, nm):
        """The 99.9th percentile over all renders, to a thousandth of the largest value."""
        if (quantity, nm) not in self.known:
            fine = self.count(quantity, nm, 1.0 if quantity == "DoLP" else None, 1000)
            counts = np.sum([s["counts"] for s in fine["series"]], axis=0)
            last = np.searchsorted(np.cumsum(counts), 0.999 * counts.sum())
            self.known[quantity, nm] = fine["low"] + (last + 1) * fine["bin_width"]
        return self.known[quantity, nm]

    def shares(self, quantity, nm, top):
        """[image][bin]; the last row of bins is what lies beyond."""
        key = quantity, nm, top
        if key not in self.known:
            rows = [s["counts"] + [s["above"]] for s in self.count(quantity, nm, top)["series"]]
            self.known[key] = {image: np.array(row) / sum(row)
                               for image, row in zip(self.images, rows)}
        return self.known[key]


def overlap(p, q):
    return np.minimum(p, q).sum()


def hellinger(p, q):
    return np.sqrt(max(0.0, 1 - np.sqrt(p * q).sum()))


def mean_and_error(values):
    return np.mean(values), np.std(values, ddof=1) / np.sqrt(len(values))


def distance(histograms, quantity, one, other):
    """Of two (target, colour, nm): overlap and Hellinger with errors, and Hellinger of noise."""
    top = max(histograms.top(quantity, one[2]), histograms.top(quantity, other[2]))
    p, q = (histograms.shares(quantity, x[2], top) for x in (one, other))
    pairs = [(p[(*one[:2], s)], q[(*other[:2], s)]) for s in SEEDS]
    noise = [hellinger(p[(*one[:2], s)], p[(*one[:2], s + 1)]) for s in SEEDS[:-1]]
    return {"overlap": mean_and_error([overlap(*pair) for pair in pairs]),
            "hellinger": mean_and_error([hellinger(*pair) for pair in pairs]),
            "noise": float(np.mean(noise))}


def comparisons():
    """What each of the study's conclusions compares: (text, one, other)."""
    paint = [(f"target {t.upper()}, {nm} nm: green and black paint", (t, "green", nm), (t, "black", nm))
             for t in TARGETS for nm in WAVELENGTHS]
    target = [(f"{c} paint, {nm} nm: target A and B", ("a", c, nm), ("b", c, nm))
              for c in COLOURS for nm in WAVELENGTHS]
    wavelength = [(f"target {t.upper()}, {c} paint: 440 and 600 nm", (t, c, 440), (t, c, 600))
                  for t, c in experiments()]
    return {"materials": paint, "targets": target, "wavelengths": wavelength}


CONCLUSIONS = [("Materials are told apart by the DoLP histogram", "materials", ("DoLP",)),
               ("Targets are told apart by the S0 histogram", "targets", ("S0",)),
               ("Wavelengths are told apart by both", "wavelengths", ("S0", "DoLP"))]


def measure(histograms):
    return {kind: [(text, {q: distance(histograms, q, one, other) for q in QUANTITIES})
                   for text, one, other in cases] for kind, cases in comparisons().items()}


def against_other(cases, quantities):
    """How often the quantity of a conclusion separates better than the other one."""
    if len(quantities) > 1:
        return ""
    this, = quantities
    other, = set(QUANTITIES) - {this}
    better = sum(d[this]["hellinger"][0] > d[other]["hellinger"][0] for _, d in cases)
    return f". {this} separates more than {other} does in {better} of {len(cases)} pairs"


def verdicts(measured):
    found = []
    for text, kind, quantities in CONCLUSIONS:
        cases = [(case, q, d[q]["overlap"][0]) for case, d in measured[kind] for q in quantities]
        apart = [c for c in cases if c[2] < 0.5]
        hellingers = [d[q]["hellinger"][0] for _, d in measured[kind] for q in quantities]
        noise = max(d[q]["noise"] for _, d in measured[kind] for q in quantities)
        worst = max(cases, key=lambda c: c[2])
        if len(apart) == len(cases):
            answer = "holds"
        else:
            answer = "does not hold here" if not apart else "holds in part"
        found.append((text, answer, f"{len(apart)} of {len(cases)} pairs overlap by less than one half; "
                                    f"the most: {worst[2]:.2f} ({worst[0]}, {worst[1]}). Hellinger's distances "
                                    f"are {min(hellingers):.2f} to {max(hellingers):.2f}, of noise alone "
                                    f"up to {noise:.2f}" + against_other(measured[kind], quantities)))
    return found


def peak_of_facets():
    """Of the facet distribution of green paint at 550 nm: 0.22 in the study."""
    output = FOLDER / "renders/peak.json"
    malus("brdf", "green_paint", "--materials", PAINTS, "--wavelengths", 550, "--incidence-zenith", 0,
          "--at", "0,0", "--json", output, "--quiet")
    peak = json.loads(output.read_text())["values"][0]["facet_distribution_per_sr"]
    if not 0.22 <= peak < 0.23:
        sys.exit(f"reproduce-study: the facet distribution of green paint peaks at {peak}, not at 0.22")
    return peak


def picture(path, text):
    data = base64.b64encode(Path(path).read_bytes()).decode()
    return f'<figure><img alt="{html.escape(text)}" src="data:image/png;base64,{data}">' \
           f"<figcaption>{html.escape(text)}</figcaption></figure>"


def sky_panels():
    image = oiio.ImageInput.open(SKY)
    names, pixels = image.spec().channelnames, image.read_image("float")
    rows, columns = pixels.shape[:2]
    azimuth = np.radians(np.linspace(0, 360, columns + 1))
    zenith = np.linspace(0, 90, rows + 1)
    figure, axes = plt.subplots(2, 3, figsize=(11, 7.4), layout="constrained",
                                subplot_kw={"projection": "polar"})
    for nm, line in zip(WAVELENGTHS, axes):
        for component, axis in zip(("S0", "S1", "S2"), line):
            values = pixels[..., names.index(f"{component}.{nm},000000nm")]
            top = np.abs(values).max()
            axis.grid(False)  # lest pcolormesh complain of it
            mesh = axis.pcolormesh(azimuth, zenith, values, vmax=top, rasterized=True,
                                   **({"cmap": "viridis", "vmin": 0} if component == "S0"
                                      else {"cmap": "RdBu_r", "vmin": -top}))
            # Looking up with north at the top, east is left.
            axis.set_theta_zero_location("N")
            axis.set_rticks([30, 60, 90], ["", "", ""])
            axis.set_xticks(np.radians([0, 90, 180, 270]), ["N", "E", "S", "W"])
            axis.grid(alpha=0.3)
            axis.set_title(f"{component}, {nm} nm")
            figure.colorbar(mesh, ax=axis, shrink=0.75, label="W m$^{-2}$ sr$^{-1}$ nm$^{-1}$")
    figure.savefig(FOLDER / "sky.png", dpi=110)
    plt.close(figure)
    return picture(FOLDER / "sky.png", "The sky above the scenes, looking up, north at the top and east left, "
                   "zenith in the middle: S0, S1 and S2, S1 > 0 polarized in the vertical plane. "
                   "Sun at zenith 60°, azimuth 135°.")


def brdf_figures():
    figures = []
    for colour, incidence in itertools.product(COLOURS, (45, 60)):
        file = FOLDER / f"brdf_{colour}_{incidence}.png"
        malus("brdf", f"{colour}_paint", "--materials", PAINTS, "--wavelengths", "440,550,600",
              "--incidence-zenith", incidence, "--png", file, "--csv", file.with_suffix(".csv"), "--quiet")
        figures.append(picture(file, f"{colour.capitalize()} paint in unpolarized light from zenith "
                                     f"{incidence}°, over all directions of the detector."))
    return "".join(figures)


def histogram_figures(histograms):
    figures = []
    for kind in ("materials", "targets"):
        for (text, one, other), quantity in itertools.product(comparisons()[kind], QUANTITIES):
            file = FOLDER / ("_".join(map(str, ("hist", quantity, *one, *other))) + ".png")
            malus("hist", *(FOLDER / f"{name_of(*x[:2])}.exr" for x in (one, other)), "--quantity", quantity,
                  "--wavelengths", one[2], "--node", "target", "--bins", BINS,
                  "--range", f"0,{float(histograms.top(quantity, one[2]))!r}", "--png", file, "--quiet")
            figures.append(picture(file, f"{quantity}, {text}, pixels of the target."))
    return f'<div class="figures">{"".join(figures)}</div>'


def number(mean_error):
    return f"{mean_error[0]:.3f} ± {max(mean_error[1], 0.0005):.3f}"


def distance_table(measured):
    head = "".join(f"<th>{q} overlap</th><th>{q} Hellinger</th><th>noise</th>" for q in QUANTITIES)
    rows = []
    for kind, cases in measured.items():
        for text, by_quantity in cases:
            cells = "".join(f'<td class="number">{number(d["overlap"])}</td>'
                            f'<td class="number">{number(d["hellinger"])}</td>'
                            f'<td class="number">{d["noise"]:.3f}</td>'
                            for d in (by_quantity[q] for q in QUANTITIES))
            rows.append(f"<tr><td>{html.escape(text)}</td>{cells}</tr>")
    return f'<div class="wide"><table><tr><th></th>{head}</tr>{"".join(rows)}</table></div>'


def intro(measured):
    answers = "".join(f"<tr><td>{html.escape(text)}</td><td><b>{answer}</b></td><td>{html.escape(why)}</td></tr>"
                      for text, answer, why in verdicts(measured))
    return f"""<p>Targets A (vehicle) and B (aircraft) in green and in black paint on black ground under a clear
sky with the sun at zenith 60°, seen from zenith 30°, azimuth 0°, at 440 and 600 nm; Gaussian slopes, two bounces. The
geometry of the targets and the sky are not the study's own, which were not published.</p>
<h2>The study's conclusions</h2>
<div class="wide"><table>{answers}</table></div>
<p class="soft">Told apart: the histograms overlap by less than one half. The distances, with their standard errors over
four renders, stand below; the pictures with all their pixels follow.</p>
<h2>Distances of histograms</h2>{distance_table(measured)}
<p class="soft">50 bins from 0 to the larger 99.9th percentile. Overlap: 1 if alike. Hellinger: 0 if
alike, at most 1. Noise: Hellinger's between two renders of the first experiment.</p>
<h2>The four experiments</h2>"""


def appendix(histograms, peak):
    return f"""<h2>Histograms</h2>{histogram_figures(histograms)}
<h2>The sky</h2>{sky_panels()}
<h2>The paints</h2><p>Peak of the facet distribution of green paint at 550 nm: {peak:.4f} sr⁻¹ (the study: 0.22).</p>
{brdf_figures()}"""


render_all()
histograms = Histograms()
measured = measure(histograms)
parts = {"--intro": intro(measured), "--appendix": appendix(histograms, peak_of_facets())}
for option, text in parts.items():
    (FOLDER / f"renders/{option[2:]}.html").write_text(text, encoding="utf-8")
malus("report", *(FOLDER / f"{name_of(t, c)}.exr" for t, c in experiments()), "--quiet",
      "--title", "Target detection in polarimetric scenes: the study's experiments",
      *(x for option in parts for x in (option, FOLDER / f"renders/{option[2:]}.html")),
      "-o", FOLDER / "report.html")
for text, answer, why in verdicts(measured):
    print(f"{text}: {answer}. {why}")
print(f"{FOLDER}/report.html: the experiments in one page; open it in a browser")
