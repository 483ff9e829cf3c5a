//! The deadzones of one joint: crossings of all its stretches, sizes and map, and its half gap for the document.

use super::*;

impl JointSweeps {
    /// A joint of which nothing but its turns is known.
    fn new(axis: usize, turns: usize) -> Self {
        let map = Map {
            half_gap: 0.0,
            ci95: [0.0; 2],
            knots: Vec::new(),
            band: Vec::new(),
            varies_p_value: None,
            scatter: 1.0,
            scatter_p_value: None,
        };
        Self {
            axis,
            deadzones: Vec::new(),
            map,
            turns,
            inside: 0,
            not_crossed: 0,
            too_short: 0,
            unseen: 0,
            unfitted: 0,
            noise_m: 0.0,
            radius_m: 0.0,
            outliers: 0,
        }
    }

    /// The deadzones that the tip crosses on the `k`-th stretch, and the count of those that it does not.
    fn crossings(&mut self, robot: &Robot, k: usize, s: &Stretch, options: &Options) -> Vec<Crossing> {
        let mut sigma = noise(s);
        let radius = |sigma: f64| options.rest_m.unwrap_or((rest::RADIUS * sigma).max(rest::LEAST_RADIUS_M));
        let mut rests = rest::find(s, radius(sigma));
        if let Some(wider) = noise_at_rest(s, &rests).filter(|w| *w > COLOURED * sigma) {
            sigma = wider;
            rests = rest::find(s, radius(sigma));
        }
        self.radius_m = self.radius_m.max(radius(sigma));
        self.inside += rests.inside(s.turns.len());
        self.not_crossed += rests.not_crossed;
        self.too_short += rests.too_short;
        self.unseen += rests.unseen;
        let axis = self.axis;
        let path = |v: f64| {
            let mut q = s.pose.clone();
            q[axis] = v;
            robot.tcp_m(&q)
        };
        let step = if robot.axis(axis).kind == JointKind::Revolute { STEP_RAD } else { STEP_M };
        let crossing = |rest: rest::Rest| {
            let at = s.turns[rest.turn];
            let bends = edge::bends(path, at.p + at.dir * rest.travel[1], step);
            Crossing { stretch: k, rest, bends, sigma, radius_m: radius(sigma) }
        };
        rests.crossed.into_iter().map(crossing).collect()
    }
}

/// Everything about one joint, or why there is nothing.
pub(super) fn joint(
    robot: &Robot,
    logs: &[Log],
    stretches: &[&Stretch],
    options: &Options,
) -> std::result::Result<JointSweeps, NoDeadzone> {
    let axis = stretches[0].axis;
    let kind = robot.axis(axis).kind;
    let mut out = JointSweeps::new(axis, stretches.iter().map(|s| s.turns.len()).sum());
    if out.turns == 0 {
        return Err(NoDeadzone::NeverTurns);
    }
    let cleaned: Vec<(Stretch, usize)> = stretches.iter().map(|s| s.without_outliers(noise(s))).collect();
    let glitches: usize = cleaned.iter().map(|c| c.1).sum();
    let stretches: &[&Stretch] = &cleaned.iter().map(|c| &c.0).collect::<Vec<_>>();
    let mut crossings = Vec::new();
    for (k, &s) in stretches.iter().enumerate() {
        crossings.extend(out.crossings(robot, k, s, options));
    }
    let mut warp = Warp::default();
    for round in 0..ROUNDS {
        let edges: Vec<Option<Edge>> = crossings.par_map(|c| c.size(stretches[c.stretch], &warp));
        out.take(&crossings, &edges, stretches, logs);
        if out.deadzones.is_empty() {
            return Err(NoDeadzone::of(&out, kind, stretches));
        }
        match map::fit(&out.deadzones.iter().map(Deadzone::sized).collect::<Vec<_>>()) {
            Some(map) => out.map = map,
            None => return Err(NoDeadzone::NoMean),
        }
        warp.gap = Pchip::new(&out.map.knots).map(GapCurve::Pchip);
        if warp.gap.is_none() || round + 1 == ROUNDS {
            break;
        }
    }
    out.outliers += glitches;
    for d in &mut out.deadzones {
        d.sigma *= out.map.scatter;
    }
    Ok(out)
}

/// A deadzone that was seen to be crossed, with what sizing it needs.
struct Crossing {
    stretch: usize,
    rest: rest::Rest,
    bends: edge::Bends,
    sigma: f64,
    radius_m: f64,
}

impl Crossing {
    fn size(&self, s: &Stretch, warp: &Warp) -> Option<Edge> {
        let edge = edge::size(s, &self.rest, &self.bends, warp, self.sigma, self.radius_m)?;
        let travel = self.rest.travel[1].max(edge.size.abs());
        (student::factor(0.95, edge.dof) * edge.sigma < WIDEST * travel).then_some(edge)
    }
}

impl Deadzone {
    fn sized(&self) -> Sized {
        Sized { from: self.from, to: self.to, size: self.size, sigma: self.sigma.max(f64::MIN_POSITIVE) }
    }
}

impl JointSweeps {
    /// The deadzones of one round; their standard errors come from the residuals of all fits of the joint together.
    fn take(&mut self, crossings: &[Crossing], edges: &[Option<Edge>], stretches: &[&Stretch], logs: &[Log]) {
        let (sse, dof) = edges.iter().flatten().fold((0.0, 0.0), |(s, d), e| (s + e.sse_m2, d + e.dof));
        self.noise_m = if dof > 0.0 { (sse / dof).sqrt() } else { 0.0 };
        self.unfitted = edges.iter().filter(|e| e.is_none()).count();
        self.outliers = edges.iter().flatten().map(|e| e.outliers).sum();
        self.deadzones.clear();
        for (c, e) in crossings.iter().zip(edges).filter_map(|(c, e)| Some((c, e.as_ref()?))) {
            let s = stretches[c.stretch];
            let at = s.turns[c.rest.turn];
            let row = s.first + s.rows(at.t_s, f64::INFINITY).start.min(s.t_s.len() - 1);
            self.deadzones.push(Deadzone {
                axis: self.axis,
                log: s.log,
                line: logs[s.log].line.get(row).copied().unwrap_or(0),
                t_s: at.t_s,
                from: at.p,
                to: at.p + at.dir * e.size,
                size: e.size,
                sigma: e.sigma * self.noise_m / c.sigma,
                rows: e.rows,
                rest_m: e.rest_m,
            });
        }
    }
}

pub(super) fn point(d: &Deadzone) -> GapPoint {
    let half = 0.5 * Z95 * d.sigma;
    let half_gap = 0.5 * d.size;
    GapPoint {
        axis: d.axis,
        at: 0.5 * (d.from + d.to),
        half_gap,
        ci95: [half_gap - half, half_gap + half],
        cycles: 1,
        per_cycle: Vec::new(),
    }
}

pub(super) fn joint_gap(found: &JointSweeps) -> JointGap {
    let m = &found.map;
    JointGap {
        sides: None,
        axis: found.axis,
        half_gap: m.half_gap,
        ci95: m.ci95,
        significant: m.ci95[0] > 0.0,
        schedule: Pchip::new(&m.knots).map(GapCurve::Pchip),
        varies_p_value: m.varies_p_value,
        stiction: None,
        stiction_p_value: None,
    }
}
