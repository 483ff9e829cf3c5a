//! The simulated instrument of Cursi (2022): its excitation, its four paths; learned, tracked and run.

use lostmotion::compensator::{BacklashOffset, Compensator};
use lostmotion::effects::curve::Pchip;
use lostmotion::effects::{Effect, EffectInstance, GapCurve, JointZeroOffset};
use lostmotion::io::input::from_bytes;
use lostmotion::learn::{self, Kind, Learned, Source, TrainingResult};
use lostmotion::log::Log;
use lostmotion::model::Model;
use lostmotion::program::Program;
use lostmotion::rewrite::{Engine, Options as RewriteOptions, OutputPoints, Points};
use lostmotion::simulate::noise::Noise;
use lostmotion::simulate::{Motion, Options as SimulateOptions, predicted};
use lostmotion::track::{self, Kinematics, Path};
use std::cell::Cell;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Sampling of the paper, s (section V-B).
pub const SAMPLE_S: f64 = 0.2;
/// Half of the motors' range in the excitation, deg: `(max - min) / 2` of section V-B, which is not printed.
const HALF_RANGE_DEG: f64 = 30.0;
/// Noise of the electromagnetic tracker, m; assumed.
pub const NOISE_M: f64 = 0.2e-3;

pub struct Instrument {
    pub model: Model,
    pub compensator: Compensator,
    /// Standard deviation of the joints' zeros from run to run, rad, and the number of the next run.
    homing: Option<(f64, Cell<u64>)>,
}

/// One of the paths, with its name.
pub struct Shape {
    pub name: &'static str,
    /// As it stands in its file.
    pub text: String,
    pub path: Path,
    /// First point of the closed figure: before it lies the way from home.
    pub closed_from: usize,
}

/// What a run on the instrument gave.
#[derive(Debug, Clone)]
pub struct Run {
    pub mean_error_mm: f64,
    /// Area inside the path that was run, over the wanted one.
    pub area_ratio: f64,
    /// x and y of every sample, mm.
    pub trace_mm: Vec<[f64; 2]>,
}

impl Instrument {
    /// From the samples.
    pub fn load() -> Self {
        let folder = std::path::Path::new(super::SAMPLES);
        let model = Model::load(&folder.join("stretched.model.yaml")).unwrap();
        let compensator = Compensator::load(&folder.join("compensator.yaml"), &model.robot).unwrap();
        Self { model, compensator, homing: None }
    }

    /// The same with what the paper says of its own: deadzones that compensation reduces by no more than Table I has it for random
    /// motions, and a home that is found by hand before each run (by 1 degree, assumed).
    pub fn by_hand() -> Self {
        const REDUCTION: [f64; 4] = [0.41, 0.26, 0.43, 0.29];
        let mut all = Self::load();
        for (joint, share) in all.compensator.joints.iter_mut().zip(REDUCTION) {
            let part = match &joint.backlash.as_ref().unwrap().positive {
                GapCurve::Pchip(p) => {
                    let knots: Vec<[f64; 2]> = p.knots().iter().map(|[at, b]| [*at, share * b]).collect();
                    GapCurve::Pchip(Pchip::new(&knots).unwrap())
                }
                curve => GapCurve::Constant(share * curve.constant().unwrap()),
            };
            joint.backlash = Some(BacklashOffset::symmetric(part));
        }
        all.homing = Some((1f64.to_radians(), Cell::new(1)));
        all
    }

    /// The machine of the next run.
    fn homed(&self) -> Model {
        let mut model = self.model.clone();
        if let Some((sigma, run)) = &self.homing {
            let mut noise = Noise::new(*sigma, run.replace(run.get() + 1)).unwrap();
            for axis in 0..model.robot.dof() {
                // normal numbers of any unit
                let offset = JointZeroOffset { offset: noise.draw_m() };
                model.effects.push(EffectInstance::on_axis(axis, Effect::new(offset)));
            }
        }
        model
    }

    /// Section V-B: every combination of two frequencies on the four motors, then each motor alone.
    pub fn excitation(&self) -> String {
        const RUN_S: f64 = 40.0;
        let mut runs: Vec<[f64; 4]> =
            (0..16).map(|c| [0, 1, 2, 3].map(|k| if c >> k & 1 == 0 { 2.0 } else { 4.0 })).collect();
        runs.extend([0, 1, 2, 3].map(|k| [0, 1, 2, 3].map(|j| if j == k { 2.0 } else { 0.0 })));
        let mut text = String::from("t_s,e1_deg,e2_deg,pitch_deg,yaw_deg\n");
        let samples = (RUN_S / SAMPLE_S) as usize;
        for (r, psi) in runs.iter().enumerate() {
            for k in 0..samples {
                let _ = write!(text, "{:.1}", (r * samples + k) as f64 * SAMPLE_S);
                for p in psi {
                    let x = TAU * p * k as f64 / samples as f64;
                    let _ = write!(text, ",{:.6}", 0.8 * HALF_RANGE_DEG * (x.sin() + 0.2 * (10.0 * x).sin()));
                }
                text.push('\n');
            }
        }
        text
    }

    pub fn program(&self, name: &str, text: String) -> Program {
        Program::parse(from_bytes(name.into(), text.into()).unwrap(), &self.model.robot).unwrap()
    }

    /// The program with the gaps compensated, steps spread over the whole sample after a reversal, as equation 2 has them.
    pub fn compensated(&self, program: &Program) -> Program {
        let axes = program.q.len();
        let mut options = RewriteOptions::new(axes);
        (options.step_fraction, options.step_exact) = (1.0, true);
        options.deadband = vec![1.5e-6f64.to_radians(); axes];
        let t_s = program.t_s.clone().unwrap();
        let q = (0..program.len()).flat_map(|i| program.q.iter().map(move |c| c[i])).collect();
        let mut out = OutputPoints::default();
        let mut engine = Engine::new(&self.model.robot, &self.compensator, options).unwrap();
        engine.push(&Points { axes, q, t_s }, &mut out).unwrap();
        let stats = engine.finish(&mut out).unwrap();
        // the command would refuse; here it is run all the same, to be measured
        if stats.violations_total > 0 {
            println!("({}: compensated, a limit is exceeded {} times)", program.name, stats.violations_total);
        }
        let mut text = String::from("t_s,e1_deg,e2_deg,pitch_deg,yaw_deg\n");
        for i in 0..out.len() {
            let _ = write!(text, "{}", out.t_s[i]);
            out.row(i).iter().for_each(|v| {
                let _ = write!(text, ",{:.6}", v.to_degrees());
            });
            text.push('\n');
        }
        self.program(&program.name, text)
    }

    /// The log of a run at the sampling of the paper, as text.
    pub fn log_text(&self, program: &Program, noise_m: f64) -> Vec<u8> {
        let t_s = program.t_s.clone().unwrap();
        let options = SimulateOptions { rate_hz: 1.0 / SAMPLE_S, noise_m, ..SimulateOptions::default() };
        let motion = Motion::of_program(&self.homed(), program, &t_s, options.rate_hz).unwrap();
        let mut text = Vec::new();
        predicted::write_program_log(&self.model, &motion, &options, &program.name, &mut text).unwrap();
        text
    }

    /// The log of a run.
    pub fn run(&self, program: &Program, noise_m: f64) -> Log {
        let text = self.log_text(program, noise_m);
        Log::parse(from_bytes("log.csv".into(), text).unwrap(), &self.model.robot).unwrap()
    }

    /// Learns x and y from the excitation, run with or without compensation.
    pub fn learn(&self, kind: Kind, compensation: bool, seed: u64) -> TrainingResult {
        let desired = self.program("excitation.csv", self.excitation());
        let log =
            if compensation { self.run(&self.compensated(&desired), NOISE_M) } else { self.run(&desired, NOISE_M) };
        let source = Source { log: &log, desired: compensation.then_some(&desired) };
        let options = learn::Options { kind, seed, coordinates: vec![0, 1], ..learn::Options::default() };
        learn::learn(&self.model.robot, &[source], &[], &options).unwrap()
    }

    /// Tracks a shape by learned kinematics, or by the nominal one.
    pub fn track(&self, shape: &Shape, learned: Option<&Learned>) -> Program {
        let robot = &self.model.robot;
        let at = &shape.path.coordinates;
        let kinematics = match learned {
            Some(l) => Kinematics::learned(l.clone(), at, "kinematics.yaml").unwrap(),
            None => Kinematics::nominal(robot, at),
        };
        let options = track::Options::default();
        let t_s = shape.path.t_s.clone().unwrap();
        let tracked = track::follow(robot, &kinematics, &shape.path, &t_s, &options).unwrap();
        // as the paper does, what can be followed is run
        if !tracked.misses.is_empty() {
            let furthest = tracked.largest_error_m() * 1e3;
            println!(
                "({}: {} points out of reach, the furthest by {furthest:.1} mm)",
                shape.name,
                tracked.misses.len()
            );
        }
        let text = track::write::program(robot, &tracked, shape.name, "");
        self.program(shape.name, String::from_utf8(text).unwrap())
    }

    /// Runs a program on the instrument and measures it as Table III does: mean distance at the same time, ratio of the areas.
    pub fn measure(&self, shape: &Shape, program: &Program, compensation: bool) -> Run {
        let log = if compensation { self.run(&self.compensated(program), 0.0) } else { self.run(program, 0.0) };
        let trace_mm: Vec<[f64; 2]> = log.tcp_m.iter().map(|p| p.map(|p| [p.x * 1e3, p.y * 1e3]).unwrap()).collect();
        let wanted: Vec<[f64; 2]> = shape.path.points_m.iter().map(|p| [p[0] * 1e3, p[1] * 1e3]).collect();
        assert_eq!(trace_mm.len(), wanted.len());
        let from = shape.closed_from;
        let errors = wanted[from..].iter().zip(&trace_mm[from..]).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        let mean_error_mm = errors.sum::<f64>() / (wanted.len() - from) as f64;
        Run { mean_error_mm, area_ratio: area(&trace_mm[from..]) / area(&wanted[from..]), trace_mm }
    }
}

/// Area inside a closed polygon.
fn area(p: &[[f64; 2]]) -> f64 {
    let next = |i: usize| p[(i + 1) % p.len()];
    (0..p.len()).map(|i| p[i][0] * next(i)[1] - next(i)[0] * p[i][1]).sum::<f64>().abs() / 2.0
}

/// The four paths of Table III: from home (0, 0) straight to the figure in 5 s, then once around in 40 s.
pub fn shapes() -> Vec<Shape> {
    vec![
        shape("ellipse_12x20", 12.0, 20.0, false),
        shape("ellipse_20x12", 20.0, 12.0, false),
        shape("rectangle_12x20", 12.0, 20.0, true),
        shape("rectangle_20x12", 20.0, 12.0, true),
    ]
}

fn shape(name: &'static str, width: f64, height: f64, rectangle: bool) -> Shape {
    const AROUND: usize = 200;
    const LEAD_IN: usize = 25;
    let (a, b) = (width / 2.0, height / 2.0);
    let around = |s: f64| {
        if !rectangle {
            let (y, x) = (TAU * s).sin_cos();
            return [a * x, b * y];
        }
        // from (a, 0) up, at one speed along the sides
        let mut left = s * 2.0 * (width + height);
        let corners = [[a, 0.0], [a, b], [-a, b], [-a, -b], [a, -b], [a, 0.0]];
        for w in corners.windows(2) {
            let length = (w[1][0] - w[0][0]).abs() + (w[1][1] - w[0][1]).abs();
            if left <= length {
                let t = left / length;
                return [w[0][0] + t * (w[1][0] - w[0][0]), w[0][1] + t * (w[1][1] - w[0][1])];
            }
            left -= length;
        }
        [a, 0.0]
    };
    let mut text = String::from("t_s,x_mm,y_mm\n");
    for k in 0..LEAD_IN + AROUND {
        let [x, y] = if k < LEAD_IN {
            [a * k as f64 / LEAD_IN as f64, 0.0]
        } else {
            around((k - LEAD_IN) as f64 / AROUND as f64)
        };
        let _ = writeln!(text, "{:.1},{x:.6},{y:.6}", k as f64 * SAMPLE_S);
    }
    let path = Path::parse(from_bytes(format!("{name}.csv"), text.clone().into()).unwrap()).unwrap();
    Shape { name, text, path, closed_from: LEAD_IN }
}
