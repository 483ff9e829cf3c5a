//! One reversal of one joint: the command that leaves the smallest largest error (Zhang (2023) equation 15, infinity norm).
//!
//! After a turn in direction `d` the joint stands at `y0`. With wanted travel `z = d (p - y0)`, friction left `G` and half
//! gap `b`, the machine (catalogue: stiction, then play) moves by `max(0, C - b - G)` for a command `C = d (c - y0)`. The
//! command that leaves no error is `H = z + b + G`. It must not turn back, for that would be one more reversal with its
//! own gap and stick; where friction fades faster than the joint moves, `H` falls and cannot be followed. What is left is an
//! isotonic fit of `H` in the infinity norm, in which an excess counts only once the joint has to move:
//!
//! ```text
//! D(k)  = max over k <= s < t of H(s) - H(t)         the largest later fall, up to where H stays above all before
//! kE    = first node at which D <= 2 z                 until there the joint may stand: its lag is z
//! C(t)  = (max over kE..t of H + min over t.. of H)/2  from kE on; C(kE) before
//! E     = max(z(kE), D(kE)/2)                          the largest error that is left
//! ```
//!
//! Where `H` rises, `C = H`. Holding at the full level `b + g` instead leaves several times more (on a slow circle 8 times).
//! At the end of the stroke the friction that is left drops out at once; the last node is fitted without it, which halves
//! that leap. Assumes that the joint sticks after a reversal; a machine that leaps instead wants a higher level.

/// One place after the turn.
#[derive(Debug, Clone, Copy, Default)]
pub struct Node {
    /// Wanted travel `z` from where the joint stands, rad or m.
    pub travel: f64,
    /// Half gap `b` there.
    pub gap: f64,
    /// Friction `G` that is left.
    pub friction: f64,
}

/// Command travel `C` at each node from `first` on, into `command`, and the largest error that is left. Nodes before
/// `first` (the step is on its way) are not touched. `open` says that the stroke ends in another turn at the last node.
pub fn solve(nodes: &[Node], first: usize, open: bool, command: &mut Vec<f64>, fall: &mut Vec<f64>) -> f64 {
    let n = nodes.len();
    command.clear();
    command.extend(nodes.iter().map(|k| k.travel + k.gap + k.friction));
    if n == 0 || first >= n {
        return 0.0;
    }
    if open {
        command[n - 1] -= nodes[n - 1].friction;
    }
    let (start, left) = hold(nodes, first, command, fall);
    // what later falls leave
    let later = nodes[start..].iter().zip(&command[start..]);
    later.map(|(m, c)| (c - m.travel - m.gap - m.friction).abs()).fold(left, f64::max)
}

/// Turns `H` at each node, in `command`, into the command from `first` on; gives the node up to which the joint may stand, and the
/// error that is left there. Where `H` rises from `first` on, nothing changes.
pub fn hold(nodes: &[Node], first: usize, command: &mut [f64], fall: &mut Vec<f64>) -> (usize, f64) {
    let n = nodes.len();
    // suffix minima: H falls to these later
    fall.clear();
    fall.resize(n, 0.0);
    let mut least = f64::INFINITY;
    for k in (first..n).rev() {
        least = least.min(command[k]);
        fall[k] = least;
    }
    // the first stretch ends where everything after stays above everything before: later falls are not its business
    let mut most = f64::NEG_INFINITY;
    let end = (first..n)
        .find(|&k| {
            most = most.max(command[k]);
            k + 1 == n || most <= fall[k + 1]
        })
        .unwrap_or(n - 1);
    // D(k) within it, from the back; kE is the first node that passes
    let (mut least, mut worst) = (f64::INFINITY, 0.0f64);
    let mut start = end;
    let mut at_start = 0.0;
    for k in (first..=end).rev() {
        least = least.min(command[k]);
        worst = worst.max(command[k] - least);
        if worst <= 2.0 * nodes[k].travel.max(0.0) {
            (start, at_start) = (k, worst);
        }
    }
    let left = nodes[start].travel.max(at_start / 2.0);
    let mut most = f64::NEG_INFINITY;
    for k in start..n {
        most = most.max(command[k]);
        command[k] = 0.5 * (most + fall[k]);
    }
    let level = command[start];
    command[first..start].fill(level);
    (start, left)
}

/// Largest error after a turn at node 0, `command` being straight between the nodes and the joint standing until the command
/// has crossed gap and friction: also on the way to the step point, where the joint lags.
pub fn largest_error(nodes: &[Node], command: &[f64]) -> f64 {
    let pull = |k: usize| command[k] - nodes[k].gap - nodes[k].friction;
    let mut out = 0.0f64;
    let mut worst = 0.0f64;
    for k in 1..nodes.len().min(command.len()) {
        let (a, b) = (pull(k - 1), pull(k));
        if a < out && b > out {
            // until here the joint stands
            let share = (out - a) / (b - a);
            let wanted = nodes[k - 1].travel + share * (nodes[k].travel - nodes[k - 1].travel);
            worst = worst.max((wanted - out).abs());
        }
        out = out.max(b);
        worst = worst.max((nodes[k].travel - out).abs());
    }
    worst
}

/// Command travel after a turn for friction that fades with the travel of the command: `x - g exp(-x/lambda) = wanted`,
/// by Newton from above; the left side rises, so the command never has to be held. `x` counts from the turn.
pub fn travel_command(wanted: f64, gain: f64, lambda: f64) -> f64 {
    let mut x = wanted + gain;
    for _ in 0..60 {
        let e = gain * (-x / lambda).exp();
        let step = (x - e - wanted) / (1.0 + e / lambda);
        x -= step;
        if step.abs() <= 1e-15 {
            break;
        }
    }
    x
}

/// Ramer-Douglas-Peucker: keeps the ends and what deviates by more than `tolerance` from the line between kept points.
pub fn thin(x: &[f64], y: &[f64], tolerance: f64, keep: &mut Vec<bool>) {
    let n = x.len();
    keep.clear();
    keep.resize(n, false);
    if n == 0 {
        return;
    }
    keep[0] = true;
    keep[n - 1] = true;
    let mut open = vec![(0usize, n - 1)];
    while let Some((a, b)) = open.pop() {
        if b <= a + 1 {
            continue;
        }
        let slope = (y[b] - y[a]) / (x[b] - x[a]);
        let (mut worst, mut at) = (tolerance, None);
        for k in a + 1..b {
            let d = (y[k] - y[a] - slope * (x[k] - x[a])).abs();
            if d > worst {
                (worst, at) = (d, Some(k));
            }
        }
        if let Some(k) = at {
            keep[k] = true;
            open.push((a, k));
            open.push((k, b));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The machine: stick, then play, in the coordinates of the stroke.
    fn moved(nodes: &[Node], command: &[f64]) -> Vec<f64> {
        let mut out = 0.0f64;
        nodes
            .iter()
            .zip(command)
            .map(|(k, c)| {
                out = out.max(c - k.gap - k.friction);
                out
            })
            .collect()
    }

    fn slow_turn(n: usize) -> Vec<Node> {
        // a = 5e-5 deg/s^2, g = 0.0034 deg, tau = 5.2 s, b = 0.0028 deg over 40 s
        (0..n)
            .map(|i| {
                let s = 40.0 * i as f64 / (n - 1) as f64;
                Node { travel: 0.5 * 5e-5 * s * s, gap: 0.0028, friction: 0.0034 * (-s / 5.2f64).exp() }
            })
            .collect()
    }

    #[test]
    fn the_command_never_turns_back() {
        let nodes = slow_turn(2000);
        let (mut c, mut f) = (Vec::new(), Vec::new());
        solve(&nodes, 0, false, &mut c, &mut f);
        assert!(c.windows(2).all(|w| w[1] >= w[0]));
    }

    #[test]
    fn the_error_left_is_the_announced_one_and_no_constant_level_does_better() {
        let nodes = slow_turn(4000);
        let (mut c, mut f) = (Vec::new(), Vec::new());
        let left = solve(&nodes, 0, false, &mut c, &mut f);
        let error =
            |c: &[f64]| moved(&nodes, c).iter().zip(&nodes).map(|(m, k)| (m - k.travel).abs()).fold(0.0, f64::max);
        // to the step of the grid
        assert!(error(&c) <= left * 1.001 && error(&c) > left * 0.97, "{} against {left}", error(&c));
        // every command that stands on one level until what it could follow without turning back has caught up with it
        let h: Vec<f64> = nodes.iter().map(|n| n.travel + n.gap + n.friction).collect();
        let mut least = h.clone();
        for k in (0..h.len() - 1).rev() {
            least[k] = least[k].min(least[k + 1]);
        }
        for i in 0..400 {
            let level = 0.0028 + 0.0034 * f64::from(i) / 400.0;
            let command: Vec<f64> = least.iter().map(|m| m.max(level)).collect();
            assert!(error(&command) >= left * 0.97, "level {level}: {} < {left}", error(&command));
        }
        // holding at the full level leaves several times more
        let full = 0.0028 + 0.0034;
        let held: Vec<f64> = nodes.iter().map(|n| (n.travel + n.gap + n.friction).max(full)).collect();
        assert!(error(&held) > 3.0 * left);
    }

    #[test]
    fn without_friction_the_command_is_the_exact_inverse() {
        let nodes: Vec<Node> =
            (0..50).map(|i| Node { travel: f64::from(i) * 1e-4, gap: 0.002, friction: 0.0 }).collect();
        let (mut c, mut f) = (Vec::new(), Vec::new());
        assert!(solve(&nodes, 0, true, &mut c, &mut f) < 1e-15);
        assert!(c.iter().zip(&nodes).all(|(c, n)| (c - n.travel - n.gap).abs() < 1e-15));
    }

    #[test]
    fn on_the_way_to_a_far_step_point_the_joint_lags_by_no_more_than_the_gap() {
        // half gap 0.002 on either side, step point 0.5 after the turn
        let node = |travel: f64| Node { travel, gap: 0.002, friction: 0.0 };
        let nodes = [node(0.0), node(0.5), node(1.0)];
        let left = largest_error(&nodes, &[-0.002, 0.502, 1.002]);
        // the joint stands for 0.004 of 0.504 of the command's way
        assert!((left - 0.5 * 0.004 / 0.504).abs() < 1e-12, "{left}");
    }

    #[test]
    fn friction_over_travel_is_inverted() {
        for z in [0.0, 1e-5, 1e-3, 0.1] {
            let x = travel_command(z + 0.005, 0.0034, 0.02);
            assert!((x - 0.0034 * (-x / 0.02f64).exp() - z - 0.005).abs() < 1e-14);
        }
    }

    #[test]
    fn thinning_keeps_what_bends() {
        let x: Vec<f64> = (0..=100).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|v| if *v < 50.0 { 0.0 } else { v - 50.0 }).collect();
        let mut keep = Vec::new();
        thin(&x, &y, 0.1, &mut keep);
        let kept: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
        assert_eq!(kept, [0, 50, 100]);
    }
}
