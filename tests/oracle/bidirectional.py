#!/usr/bin/env python3
"""Independent truth for `assess bidirectional`: statsmodels on made readings.

    bidirectional.py > bidirectional.json          # numbers, and the tables as statsmodels prints them
    bidirectional.py samples DIR                   # the sample readings of samples/bidirectional

statsmodels 0.15, numpy 2, pandas. Seven data sets; each is the CSV that the program reads, and what statsmodels makes of it:
lack of fit by anova_lm of the polynomial against the model with one mean a pose (single readings, OLS), Student tests of the
indicator variables and the final model by WLS of the poses' means, or OLS of single readings where there is one state.
Degree and terms are not chosen here: the script prints the tests of every degree and order, the test checks the choice.
"""
import io
import json
import sys

import numpy as np
import pandas as pd
import statsmodels.api as sm
import statsmodels.formula.api as smf
from statsmodels.stats.anova import anova_lm

# Slamani, Nubiola, Bonev: equations 26 and 27 (um over mm); scatter: middle of the ranges of figures 3 and 4
Z = dict(x=[0, 200, 400, 600, 800], b=[33.83, -0.0914, 0.0001], speed=42.6, sf=14.5 / 3, sb=13 / 3)
Y = dict(x=[0, 250, 500, 750, 1000], b=[-63.8, 0.0241, -0.00001], speed=52.44, sf=4.5 / 3, sb=5.5 / 3)


def readings(rng, x, curve, repeats, sf, sb, states=((),), names=(), drift=0.0):
    """Rows of a test: runs forward and back through all positions; curve(x, state) is forward less backward."""
    rows = []
    for state in states:
        for u in range(1, repeats + 1):
            walk = drift * rng.standard_normal()
            up = {p: walk + rng.normal(0, sf) for p in x}
            down = {p: walk + rng.normal(0, sb) for p in x}
            for p in x:
                e = up[p] + 20 * np.sin(p / 150) + curve(p, state)
                rows.append((p, 1, u, round(e, 3), *state))
            for p in reversed(x):
                rows.append((p, -1, u, round(down[p] + 20 * np.sin(p / 150), 3), *state))
    return pd.DataFrame(rows, columns=["position_mm", "direction", "repeat", "error_um", *names])


def paper(rng, k):
    """All four runs that the paper names: 10, 1000 (halfway), 6000 mm/s at 2.23 kg, 10 mm/s at 6 kg."""
    poly = np.polynomial.polynomial.polyval

    def curve(p, s):
        return poly(p, k["b"]) + k["speed"] * {10: 0, 1000: 0.4, 6000: 1}[s[0]]

    states = [(10, 2.23), (6000, 2.23), (10, 6)]
    return readings(rng, k["x"], curve, 10, k["sf"], k["sb"], states, ["speed_mm_s", "payload_kg"], 3.0)


def sets():
    rng = np.random.default_rng(20120501)
    poly = np.polynomial.polynomial.polyval
    yield "paper_z", paper(rng, Z), ["speed_mm_s", "payload_kg"]
    yield "paper_y", paper(rng, Y), ["speed_mm_s", "payload_kg"]
    x = [-400, -250, -100, 0, 80, 200, 390]
    yield "cubic_unequal_poses", readings(rng, x, lambda p, s: poly(p / 100, [-20, 3, 1.2, -0.6]), 6, 2, 3, drift=8), []
    # a state with a slope of its own, and a text state
    states = [("cold",), ("warm",), ("hot",)]
    def slope(p, s):
        return -30 + 0.02 * p + {"cold": 0, "warm": -6, "hot": -6 - 0.03 * p}[s[0]]
    yield "text_states_slope", readings(rng, [0, 100, 200, 300, 400, 500], slope, 5, 1.5, 1.5, states, ["machine"]), ["machine"]
    # unequal numbers of repeats: readings are lost
    lost = readings(rng, [0, 150, 300, 450, 600, 750], lambda p, s: -12 - 0.03 * p + 4e-5 * p * p + (5 if s[0] == 2 else 0), 8, 1.5, 2,
                    [(1,), (2,)], ["tool"])
    lost.loc[rng.choice(len(lost), 23, replace=False), "error_um"] = np.nan
    yield "missing_cells", lost, ["tool"]
    # five speeds
    speeds = [(v,) for v in (10, 100, 500, 1000, 2000)]
    yield "five_speeds", readings(rng, [0, 50, 100, 150, 200], lambda p, s: -8 - 0.004 * s[0] + 0.01 * p, 4, 1, 1, speeds, ["speed_mm_s"]), ["speed_mm_s"]
    # positions far from 0 and few repeats: powers of the position would be ill conditioned
    far = [10000 + 40 * i for i in range(9)]
    yield "far_from_0", readings(rng, far, lambda p, s: 25 * np.sin((p - 10000) / 90), 3, 1, 1), []


def pairs(df, states):
    keys = ["position_mm", "repeat", *states]
    f = df[df.direction == 1].set_index(keys).error_um
    b = df[df.direction == -1].set_index(keys).error_um
    y = (f - b).dropna().rename("y").reset_index()
    return y


def printed(result):
    """Rows of the coefficients as `summary()` prints them: name, coef, std err, t, P>|t|, [0.025, 0.975]."""
    return [list(map(str, r)) for r in result.summary().tables[1].data[1:]]


def terms(degree, prefix=""):
    return [f"{prefix}I(x**{k})" for k in range(1, degree + 1)]


def formula(degree, orders):
    """orders: {indicator column: highest order or None}."""
    parts = ["1", *terms(degree)]
    for d, order in orders.items():
        parts += [d, *[f"{d}:I(x**{k})" for k in range(1, order + 1)]]
    return "y ~ " + " + ".join(parts)


def lack(data, f_formula, mean_formula):
    """F of the model against one mean a pose."""
    small, large = smf.ols(f_formula, data).fit(), smf.ols(mean_formula, data).fit()
    table = anova_lm(small, large)
    row = table.iloc[1]
    return {"F": row["F"], "p_value": row["Pr(>F)"], "dof": [row["df_diff"], table.iloc[1]["df_resid"]],
            "lack": row["ss_diff"], "pure": large.ssr, "printed": table.to_string().splitlines()}


def analyse(name, df, states):
    data = pairs(df, states)
    # centred and scaled for the fits, so that statsmodels keeps its digits; F and t of the highest term do not change
    centre, scale = data.position_mm.mean(), np.ptp(data.position_mm) / 2
    data["x"] = (data.position_mm - centre) / scale
    data["state"] = data[states].astype(str).agg("|".join, axis=1) if states else "-"
    order = list(dict.fromkeys(df[states].astype(str).agg("|".join, axis=1))) if states else ["-"]
    base = data[data.state == order[0]]
    out = {"name": name, "csv": df.to_csv(index=False), "reference": order[0]}
    n = base.position_mm.nunique()
    out["lack_of_fit"] = [{"degree": d, **lack(base, formula(d, {}), "y ~ C(position_mm)")} for d in range(1, n - 1) if d <= 6]
    out["poses"] = []
    for (state, p), g in (df.assign(state=df[states].astype(str).agg("|".join, axis=1) if states else "-")
                          .groupby(["state", "position_mm"], sort=False)):
        f, b = g[g.direction == 1].error_um.dropna(), g[g.direction == -1].error_um.dropna()
        y = data[(data.state == state) & (data.position_mm == p)].y
        whole = len(y) == len(f) == len(b)
        if whole:
            ci = sm.stats.DescrStatsW(y).tconfint_mean(0.05)
        else:
            cm = sm.stats.CompareMeans(sm.stats.DescrStatsW(f), sm.stats.DescrStatsW(b))
            ci = cm.tconfint_diff(0.05, usevar="unequal")
        sf, sb, d = f.std(ddof=1), b.std(ddof=1), f.mean() - b.mean()
        out["poses"].append({"state": state, "position_mm": p, "backlash_um": d, "ci95": list(ci), "forward": 3 * sf,
                             "backward": 3 * sb, "R": max(3 * sf + 3 * sb + abs(d), 6 * sf, 6 * sb)})
    means = data.groupby(["state", "position_mm", "x"]).y.agg(["mean", "size"]).reset_index().rename(columns={"mean": "y"})
    out["students"] = []
    top = out["lack_of_fit"][-1]["degree"]
    for degree in range(1, min(top, 3) + 1):
        for s in order[1:]:
            pair = means[means.state.isin([order[0], s])].copy()
            pair["D"] = (pair.state == s).astype(float)
            for k in range(0, degree + 1):
                fit = smf.wls(formula(degree, {"D": k}), pair, weights=pair["size"]).fit()
                if fit.df_resid < 1:
                    continue
                term = "D" if k == 0 else f"D:I(x ** {k})"
                ci = fit.conf_int().loc[term]
                out["students"].append({"degree": degree, "state": s, "order": k, "t": fit.tvalues[term], "p_value": fit.pvalues[term],
                                        "dof": fit.df_resid, "coefficient": fit.params[term] / scale**k,
                                        "ci95": [ci[0] / scale**k, ci[1] / scale**k]})
    # the curve in powers of the position itself, as it is printed; positions far from 0 only through the centred fit
    out["curves"] = []
    for degree in range(1, min(top, 5) + 1):
        if states:
            continue
        raw = data.assign(x=data.position_mm.astype(float))
        fit = smf.ols(formula(degree, {}), data).fit()
        grid = np.linspace(data.position_mm.min(), data.position_mm.max(), 7)
        at = fit.get_prediction(pd.DataFrame({"x": (grid - centre) / scale})).summary_frame(0.05)
        one = {"degree": degree, "grid_mm": list(grid), "fit": list(at["mean"]), "low": list(at["mean_ci_lower"]), "high": list(at["mean_ci_upper"])}
        if name != "far_from_0":
            direct = smf.ols(formula(degree, {}), raw).fit()
            one |= {"params": list(direct.params), "ci95": direct.conf_int().values.tolist(), "printed": printed(direct)}
        out["curves"].append(one)
    # the two-state models in powers of the position, as printed
    out["printed_pairs"] = []
    if states and name != "far_from_0":
        for s in order[1:]:
            pair = means[means.state.isin([order[0], s])].copy()
            pair["D"] = (pair.state == s).astype(float)
            pair["x"] = pair.position_mm.astype(float)
            fit = smf.wls(formula(2, {"D": 0}), pair, weights=pair["size"]).fit()
            out["printed_pairs"].append({"state": s, "degree": 2, "order": 0, "printed": printed(fit)})
    return out


def samples(folder):
    rng = np.random.default_rng(1600)
    for name, k in (("z", Z), ("y", Y)):
        df = paper(rng, k)
        text = io.StringIO()
        text.write("# Made readings, not measured: Slamani, Nubiola and Bonev, equation %s and the scatter of figure %s;\n" % (("26", "3") if name == "z" else ("27", "4")))
        text.write("# tests/oracle/bidirectional.py samples\n")
        df["direction"] = df.direction.map({1: "+1", -1: "-1"})
        df.to_csv(text, index=False)
        open(f"{folder}/irb1600_{name}.csv", "w").write(text.getvalue())


if __name__ == "__main__":
    if sys.argv[1:2] == ["samples"]:
        samples(sys.argv[2])
    else:
        json.dump([analyse(*s) for s in sets()], sys.stdout, indent=0)
        print()
