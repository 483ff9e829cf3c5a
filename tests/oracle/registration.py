#!/usr/bin/env python3
"""Rigid registration by scipy.spatial.transform.Rotation.align_vectors: registration.py > registration.json.

Points of a robot's cell (m), moved by a known frame, with noise of 11 um (seed 7). scipy aligns centred vectors; the translation
follows from the centroids. `rotation_variance` is scipy's sensitivity matrix times the residual's variance over 3 n - 6.
"""
import json
import numpy as np
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(7)
cases = []
for n, spread in ((3, (1.0, 0.8, 0.5)), (40, (1.0, 0.8, 0.5)), (60, (0.9, 0.2, 0.0)), (200, (0.05, 0.04, 0.03))):
    x = rng.uniform(-1, 1, (n, 3)) * spread + [1.5, 0.2, 1.1]
    turn = Rotation.from_rotvec(rng.uniform(-2, 2, 3))
    y = turn.apply(x) + [2.65, 1.89, -0.64] + rng.normal(0, 11e-6, (n, 3))
    cx, cy = x.mean(0), y.mean(0)
    found, rssd, sensitivity = Rotation.align_vectors(y - cy, x - cx, return_sensitivity=True)
    s2 = rssd ** 2 / (3 * n - 6)
    cases.append({"base_m": x.tolist(), "tracker_m": y.tolist(), "rotation": found.as_matrix().tolist(),
                  "translation_m": (cy - found.apply(cx)).tolist(), "rms_m": rssd / np.sqrt(3 * n),
                  "sigma_rad": np.sqrt(np.diag(sensitivity) * s2).tolist()})
print(json.dumps(cases))
