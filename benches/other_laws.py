"""Other laws for a generator of random machines than those that it draws by default: what `identify` does where friction, gaps and noise
are of none of the forms that were in sight when it was made.

A generator that takes `--laws FILE.py` runs this file with its own classes `Friction`, `Gap`, `Tracker` and `Warming` in reach.
Friction: Bouc-Wen; slip that starts at once, worked off at two paces. Gaps: worn at one place; larger under load; two in a row, the
second soft. Noise: Student's t with 2.5 degrees of freedom beside the instrument's own, and a scale that wanders with the air.
"""

import numpy as np
from __main__ import Friction, Gap, Tracker, Warming
from scipy.signal import lfilter


class BoucWen(Friction):
    def slip(self, x, level, reach, rng):
        dx, z, out = (np.diff(x, prepend=x[0]) / reach).tolist(), 0.0, []
        for d, limit in zip(dx, level.tolist()):
            limit, step, way = max(limit, 0.05), min(abs(d), 6.0), np.sign(d)
            for _ in range(12):
                held = min(abs(z / limit), 1) ** 1.6 * np.sign(z) if way * z > 0 else 0.0
                z += 1.6 * step / 12 * (way - held)
            z = min(max(z, -limit), limit)
            out.append(z)
        return np.array(out)


class TwoPace(Friction):
    def slip(self, x, level, reach, rng):
        z, out = 0.0, []
        for d, limit in zip((np.diff(x, prepend=x[0]) / reach).tolist(), level.tolist()):
            z = min(max(z + 1.3 * d, -limit), limit)
            out.append(z)
        return np.array(out)

    def servo(self, x, load, temp, rng):
        f = self.slip(x, self.level(x, load, temp), self.reach, rng)
        f = np.concatenate([[f[0]], f])
        parts = ((0.6, self.decay), (0.4, self.decay * 5))
        return sum(-w * self.spike * lfilter([1, -1], [1, -np.exp(-0.01 / d)], f)[1:] for w, d in parts)


class WornGap(Gap):
    def __init__(self, rng, size, centre, span):
        super().__init__(rng, size, centre, span)
        self.at, self.width = centre + span * rng.uniform(-0.3, 0.3), span * rng.uniform(0.05, 0.12)
        self.more = rng.uniform(0.4, 1.2)

    def half(self, x, load):
        return self.size * (1 + self.more * np.exp(-0.5 * ((x - self.at) / self.width) ** 2))


class LoadGap(Gap):
    def __init__(self, rng, size, centre, span):
        super().__init__(rng, size, centre, span)
        self.by = rng.uniform(0.2, 0.6)

    def half(self, x, load):
        return self.size * (1 + self.by * np.clip(load, -1, 1))


class TwoStage(Gap):
    def transmit(self, m, x, load, rng):
        y, s, z, out = super().transmit(m, x, load, rng), 0.35 * self.size, 0.0, []
        for d in np.diff(y, prepend=y[0]).tolist():
            z = min(max(z + (d - abs(d) * z / s if abs(d) < s else 0), -s), s)
            out.append(z)
        return y - np.array(out)


class Heavy(Tracker):
    def measure(self, p, t, rng):
        q, n = super().measure(p, t, rng), len(p)
        q = q + 2.0e-3 * rng.standard_t(2.5, (n, 3))
        return q * (1 + 1.0e-6 * np.cumsum(rng.standard_normal(n))[:, None] * np.sqrt(0.04 / 60))


LAWS = {"friction": [BoucWen, TwoPace], "gap": [WornGap, LoadGap, TwoStage], "noise": [Heavy], "thermal": [Warming]}
SHARES = {"gap": None}
