//! Traction of a raceway contact by few points: six Gauss points for a gentle law, seventeen strips for a steep one.
//!
//! The reference of each contact is the integral of the law over the ellipse by 129 strips, evaluated here from the geometry of the
//! contact. Strips of the same rule reproduce the program to rounding, which proves the reference.

use raceway::physics::contact::strips::{Strip, Strips, load_share_below};
use raceway::physics::contact::traction::{Traction, TractionContext, TractionLaw};
use raceway::physics::raceway::{RacewayContact, RacewayTerms, RelativeMotion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::terms::{ActiveTerms, Justification};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient, settings};
use crate::scenes::{article, changed, needs, scene};

/// Strips of the reference.
const FINE: usize = 129;
/// Error of traction that no other number shows, as a share of the largest traction [-].
const NEGLIGIBLE: f64 = 1e-3;

/// The bearings whose contacts are compared.
const BEARINGS: [&str; 2] = ["article-integrated", "6205"];

fn with_law(bearing: &str, law: Value) -> Scene {
    scene(&json!({
        "bearing": bearing, "operation": { "speed_rpm": 20_000, "radial_load_y_n": 200 },
        "lubricant": { "kind": "grease", "traction": law }
    }))
}

fn rising_until(at_slip: f64) -> Value {
    json!({ "law": "four_parameter", "at_slip_m_s": at_slip })
}

/// One contact: a raceway by its own points, and what the reference needs of its geometry.
struct Contact<'a> {
    scene: &'a Scene,
    is_outer: bool,
    terms: RacewayTerms,
}

/// Shares of the normal load: traction along the groove and across it [-].
type Shares = [f64; 2];

impl Contact<'_> {
    fn raceway(&self, points: (usize, bool)) -> RacewayContact {
        let (strips, gauss) = points;
        let terms = RacewayTerms { strips, gauss, hydrodynamics: false, ..self.terms };
        let Scene { bearing, lubricant, .. } = self.scene;
        let pair = RacewayContact::pair(bearing, lubricant, self.scene.raceway_damping.resolve(), terms);
        if self.is_outer { pair.outer } else { pair.inner }
    }

    /// A ball that rolls on this raceway under a load [N], but for a slip along the groove and across it [m/s]. `spin`: of the ball about
    /// the normal, over its spin about its own axis [-]. `angle`: of the contact [rad].
    fn motion(&self, load: f64, (along, across): (f64, f64), spin: f64, angle: f64) -> RelativeMotion {
        let p = &self.scene.bearing.parameters;
        let raceway = self.raceway((1, false));
        let side = if self.is_outer { 1.0 } else { -1.0 };
        let ball_radius = 0.5 * p.ball_diameter;
        let depth = raceway.relative_depth(load) * ball_radius;
        let centres = &self.scene.bearing.groove_centre_radius;
        let centre = if self.is_outer { centres.outer } else { centres.inner };
        let reach = raceway.touch_distance() + depth;
        let towards = (angle.sin(), side * angle.cos());
        let radius = centre + reach * towards.1;
        let speed = self.scene.operating_speed();
        // Spin of ideal rolling; the slip is that of the velocity.
        let rolling = 0.5 * speed * p.pitch_diameter / p.ball_diameter;
        let spin_a = -rolling * angle.cos();
        let spin_r = spin * rolling * side;
        let mut motion = RelativeMotion {
            axial: reach * towards.0,
            radius,
            velocity: [0.0; 3],
            spin: [spin_a, spin_r, 0.0],
            raceway_speed: if self.is_outer { 0.0 } else { speed },
            orbit_speed: 0.4 * speed,
            azimuth: 0.0,
        };
        // Velocities across the groove and along it are what is left to the slip that is asked for.
        let slip = self.raceway((1, false)).load::<false>(&motion).slip;
        let missing = (along - slip.0, across - slip.1);
        let across_direction = (-towards.1, towards.0);
        motion.velocity =
            [-missing.1 * across_direction.0, -missing.1 * across_direction.1, motion.velocity[2] - missing.0];
        motion
    }

    /// Variation of the slip over the ellipse [m/s]: a² Ω/(2 R_d) by conformity, and a Ω sin α with a share of spin.
    fn slip_variation(&self, load: f64, spin: f64, angle: f64) -> (f64, f64) {
        let p = &self.scene.bearing.parameters;
        let rolling = 0.5 * self.scene.operating_speed() * p.pitch_diameter / p.ball_diameter;
        let raceway = self.raceway((1, false));
        let (semi_major, _) = raceway.hertz().semi_axes(load);
        let by_conformity = 0.5 * semi_major * semi_major * rolling / raceway.hertz().deformed_radius;
        (by_conformity, semi_major * rolling * (angle.sin() + spin))
    }

    /// Traction over the normal load by the program.
    fn by(&self, points: (usize, bool), motion: &RelativeMotion) -> Shares {
        let load = self.raceway(points).load::<false>(motion);
        assert!(load.normal > 0.0);
        let (sine, cosine) = self.towards(motion);
        let across = load.force[0] * -cosine + load.force[1] * sine;
        [load.force[2] / load.normal, across / load.normal]
    }

    fn towards(&self, motion: &RelativeMotion) -> (f64, f64) {
        self.raceway((1, false)).penetration::<false>(motion.axial, motion.radius).1
    }

    /// The same by strips that are evaluated here.
    fn integral(&self, strips: &[Strip], motion: &RelativeMotion) -> Shares {
        let raceway = self.raceway((1, false));
        let (penetration, (towards_a, towards_r)) = raceway.penetration::<false>(motion.axial, motion.radius);
        let hertz = raceway.hertz();
        let elastic = raceway.elastic_load(penetration).0;
        let lubricant = &self.scene.lubricant;
        let law = Traction::new(&lubricant.traction, lubricant.viscosity, lubricant.pressure_viscosity);
        let semi_major = hertz.semi_axes(elastic).0;
        let ball_radius = 0.5 * self.scene.bearing.parameters.ball_diameter;
        let edge = (ball_radius * ball_radius - semi_major * semi_major).sqrt();
        let shift = edge - (hertz.deformed_radius * hertz.deformed_radius - semi_major * semi_major).sqrt();
        let height = |place: f64| (hertz.deformed_radius * hertz.deformed_radius - place * place).sqrt() + shift;
        let relative = motion.raceway_speed - motion.spin[0];
        let per_height = relative * towards_r + motion.spin[1] * towards_a;
        let per_place = relative * towards_a - motion.spin[1] * towards_r;
        let base = motion.raceway_speed * motion.radius - motion.velocity[2];
        let side = motion.velocity[0] * towards_r - motion.velocity[1] * towards_a;
        let pressure = hertz.max_pressure(elastic);
        let mut sums = [0.0; 2];
        for strip in strips {
            let place = strip.position * semi_major;
            let along = base + height(place) * per_height + place * per_place;
            let square = along * along + side * side;
            let context = TractionContext { pressure: strip.pressure * pressure, ..self.context(&raceway, motion) };
            let factor = strip.weight * law.traction_over_speed(square, &context);
            sums = [sums[0] + factor * along, sums[1] + factor * side];
        }
        sums
    }

    fn context(&self, raceway: &RacewayContact, motion: &RelativeMotion) -> TractionContext {
        TractionContext { rolling_speed: raceway.rolling_speed(motion).abs(), pressure: 0.0, film_thickness: 1e-7 }
    }
}

/// Strips of equal width without the limit of their number that the program has.
fn fine_strips(count: usize) -> Vec<Strip> {
    let edge = |i: usize| (2 * i) as f64 / count as f64 - 1.0;
    let moment = |t: f64| 0.75 * t * t * (0.5 - 0.25 * t * t);
    (0..count)
        .map(|i| {
            let weight = load_share_below(edge(i + 1)) - load_share_below(edge(i));
            let position = (moment(edge(i + 1)) - moment(edge(i))) / weight;
            Strip { position, weight, pressure: std::f64::consts::FRAC_PI_4 * (1.0 - position * position).sqrt() }
        })
        .collect()
}

/// Largest traction coefficient of a law [-].
fn largest(law: &TractionLaw) -> f64 {
    match *law {
        TractionLaw::FourParameter { maximum, .. } => maximum,
        TractionLaw::Coulomb { coefficient, .. } => coefficient,
        TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. } => panic!("no largest traction"),
    }
}

/// Contacts of a scene over loads, slips, spins and contact angles.
fn grid(scene: &Scene) -> Vec<(Contact<'_>, RelativeMotion)> {
    grid_within(scene, |_, _| true)
}

/// Those of them whose slip varies over the ellipse by so much [m/s]: by conformity, and by spin about the normal.
fn grid_within(scene: &Scene, is_within: impl Fn(f64, f64) -> bool) -> Vec<(Contact<'_>, RelativeMotion)> {
    let terms = needs(scene, Some(ModelLevel::Full)).raceway;
    let law_slip = match scene.lubricant.traction {
        TractionLaw::FourParameter { at_slip, .. } => at_slip,
        TractionLaw::Coulomb { regularisation, .. } => regularisation,
        _ => 1.0,
    };
    let mut all = Vec::new();
    for is_outer in [false, true] {
        for load in [2.0, 20.0, 100.0, 400.0] {
            // From rolling to far beyond saturation, and slips of an ordinary run.
            let shares = [0.0, 0.02, 0.1, 0.3, 1.0, 3.0].map(|share| share * law_slip);
            for slip in shares.into_iter().chain([1e-3, 0.01, 0.05, 0.2]).flat_map(|slip| [slip, -slip]) {
                for (across, spin, angle) in [(0.0, 0.0, 0.0), (0.0, 0.0, 0.02), (0.02, 0.02, 0.1), (0.1, 0.0, 0.4)] {
                    let contact = Contact { scene, is_outer, terms };
                    let (by_conformity, by_spin) = contact.slip_variation(load, spin, angle);
                    if !is_within(by_conformity, by_spin) {
                        continue;
                    }
                    let motion = contact.motion(load, (slip, across * slip), spin, angle);
                    all.push((contact, motion));
                }
            }
        }
    }
    all
}

/// Rms and largest error of points over a grid, as shares of the largest traction [-].
fn errors(scene: &Scene, points: (usize, bool)) -> [f64; 2] {
    errors_of(scene, points, grid(scene))
}

fn errors_of(scene: &Scene, points: (usize, bool), grid: Vec<(Contact<'_>, RelativeMotion)>) -> [f64; 2] {
    let fine = fine_strips(FINE);
    let scale = largest(&scene.lubricant.traction);
    let (mut squares, mut worst, mut count) = (0.0, 0.0, 0.0);
    for (contact, motion) in grid {
        let (found, expected) = (contact.by(points, &motion), contact.integral(&fine, &motion));
        let error = (found[0] - expected[0]).hypot(found[1] - expected[1]) / scale;
        squares += error * error;
        worst = f64::max(worst, error);
        count += 1.0;
    }
    [f64::sqrt(squares / count), worst]
}

const GAUSS: (usize, bool) = (6, true);

/// The reference is the rule of the program with more strips.
#[test]
fn the_reference_is_the_integral_of_the_program() {
    for bearing in BEARINGS {
        let scene = with_law(bearing, rising_until(1.0));
        for (contact, motion) in grid(&scene) {
            for strips in [9, 17] {
                let found = contact.by((strips, false), &motion);
                let expected = contact.integral(Strips::new(strips).as_slice(), &motion);
                for k in 0..2 {
                    assert!((found[k] - expected[k]).abs() < 1e-10, "{found:?} {expected:?} {motion:?}");
                }
            }
        }
    }
}

/// Where the slip varies over the ellipse by no more than the saturation slip, six Gauss points err by a quarter more than nine strips at most in the mean, and by
/// no more than twice as much at worst. The variation is a² Ω/(2 R_d) by conformity and a Ω sin α by spin about the normal.
#[test]
fn six_points_integrate_a_gentle_law_as_well_as_nine_strips() {
    for bearing in BEARINGS {
        for at_slip in [0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0] {
            let scene = with_law(bearing, rising_until(at_slip));
            let gentle = || grid_within(&scene, |conformity, spin| conformity + spin <= at_slip);
            if gentle().is_empty() {
                continue;
            }
            let (gauss, strips) = (errors_of(&scene, GAUSS, gentle()), errors_of(&scene, (9, false), gentle()));
            println!("{bearing}, {at_slip} m/s: six points {gauss:?}, nine strips {strips:?}");
            assert!(gauss[0] <= 1.25 * strips[0].max(NEGLIGIBLE), "{bearing}, {at_slip} m/s: {gauss:?} {strips:?}");
            assert!(gauss[1] <= 2.0 * strips[1].max(NEGLIGIBLE), "{bearing}, {at_slip} m/s: {gauss:?} {strips:?}");
        }
    }
}

/// The variation of the slip in the most loaded contact decides: gentle laws have six points, steep ones seventeen strips.
#[test]
fn the_variation_of_the_slip_decides() {
    let terms =
        |at_slip: f64| needs(&with_law("article-integrated", rising_until(at_slip)), Some(ModelLevel::Full)).raceway;
    assert!([0.5, 1.0, 10.0].iter().all(|at_slip| terms(*at_slip).gauss && terms(*at_slip).strips == 6));
    assert!([0.005, 0.02, 0.05].iter().all(|at_slip| !terms(*at_slip).gauss && terms(*at_slip).strips == 17));
}

/// Steep laws have seventeen strips, which err by less than six Gauss points.
#[test]
fn seventeen_strips_integrate_a_steep_law_better_than_six_points() {
    for bearing in BEARINGS {
        let coulomb = |speed: f64| json!({ "law": "coulomb", "coefficient": 0.05, "regularisation_m_s": speed });
        for law in [rising_until(0.001), rising_until(0.005), rising_until(0.01), coulomb(0.001), coulomb(0.01)] {
            let scene = with_law(bearing, law.clone());
            let terms = needs(&scene, Some(ModelLevel::Full)).raceway;
            let (gauss, strips) = (errors(&scene, GAUSS), errors(&scene, (17, false)));
            println!("{bearing}, {law}: six points {gauss:?}, seventeen strips {strips:?}");
            assert!(!terms.gauss && terms.strips == 17, "{bearing}, {law}: {terms:?}");
            assert!(strips[0] < gauss[0] && strips[1] < gauss[1], "{bearing}, {law}: {gauss:?} {strips:?}");
        }
    }
}

/// Without spin about the normal a strip and its image slip alike: half of them give the same to rounding.
#[test]
fn folded_strips_are_an_identity() {
    let scene = scene(&article());
    let needs = ActiveTerms::of(&scene, &levels_only(), Some(ModelLevel::Full)).unwrap();
    let damping = scene.raceway_damping.resolve();
    for (strips, gauss) in [GAUSS, (9, false), (17, false)] {
        let pair = |spin: bool| {
            let terms = RacewayTerms { spin, strips, gauss, ..needs.raceway };
            RacewayContact::pair(&scene.bearing, &scene.lubricant, damping, terms)
        };
        // A ball 3 µm into the outer raceway, none of whose motion turns about the normal there.
        let motion = RelativeMotion {
            radius: 6.5e-3 + 4.25e-6,
            velocity: [0.0, 0.0, 13.4],
            spin: [-11_600.0, 0.0, 500.0],
            orbit_speed: 2060.0,
            ..RelativeMotion::default()
        };
        let (with, without) = (pair(true).outer.load::<false>(&motion), pair(false).outer.load::<false>(&motion));
        assert!(with.normal > 1.0);
        for k in 0..3 {
            assert!((with.force[k] - without.force[k]).abs() <= 1e-14 * with.normal, "{with:?} {without:?}");
            assert!((with.moment[k] - without.moment[k]).abs() <= 1e-17 * with.normal, "{with:?} {without:?}");
        }
    }
}

/// Scenes of different loads, clearances, speeds, numbers of balls, masses and lubricants.
fn scenes() -> Vec<(&'static str, Value)> {
    let speed_and_load =
        |rpm: f64, newtons: f64| json!({ "operation": { "speed_rpm": rpm, "radial_load_y_n": newtons } });
    let bearing =
        |balls: u32, clearance: f64| json!({ "bearing": { "ball_count": balls, "radial_clearance_um": clearance } });
    let closed = json!({ "bearing": { "radial_clearance_um": 3, "cage": { "seat": "closed", "offset_mm": 0 } } });
    vec![
        ("article", json!({})),
        ("unbalance", json!({ "spindle": { "balance_grade": 6.3 } })),
        ("small clearance", bearing(7, 2.0)),
        ("large clearance, eight balls", bearing(8, 10.0)),
        ("six balls", bearing(6, 5.0)),
        ("50 N", speed_and_load(50_000.0, 50.0)),
        ("400 N", speed_and_load(50_000.0, 400.0)),
        ("60 000 r/min", speed_and_load(60_000.0, 200.0)),
        ("20 000 r/min", speed_and_load(20_000.0, 100.0)),
        ("heavy spindle", json!({ "spindle": { "mass_kg": 0.1 } })),
        ("oil", json!({ "lubricant": "oil" })),
        ("air in place of a mixture", json!({ "lubricant": { "fill": 0 } })),
        ("in the plane", closed),
    ]
}

fn levels_only() -> Outputs {
    Outputs { contacts: false, cage: false, ..settings().outputs }
}

/// 20 ms to settle and 20 ms recorded on the dynamics; `tolerance_db` of the model.
fn asked(tolerance_db: f64, outputs: Outputs) -> RunSettings {
    RunSettings {
        model_tolerance_db: tolerance_db,
        rung: Some(ModelLevel::Full),
        duration: 0.02,
        outputs,
        ..settings()
    }
}

fn levels(result: &RunResult) -> [f64; 2] {
    [Y, Z].map(|channel| {
        let found = result.summary.channels.iter().find(|(of, _)| *of == channel);
        found.and_then(|(_, metrics)| metrics.level_db).unwrap()
    })
}

/// Errors of integration, of level and repetition, at 1e-5 [dB].
const INTEGRATION: f64 = 2e-3;

/// The full model has the same equations at every `model_tolerance_db`: its levels are equal, and it leaves out no term by judgement.
#[test]
fn the_model_tolerance_does_not_change_the_full_model() {
    for (name, changes) in scenes() {
        let json = changed(article(), changes);
        let [whole, tolerant] = [0.0, 0.05].map(|tolerance| {
            let result = simulate(&scene(&json), &asked(tolerance, levels_only()), &patient()).unwrap();
            assert!(
                result.left_out.iter().all(|one| one.by != Justification::Judgement),
                "{name}: {:?}",
                result.left_out
            );
            assert_eq!(result.summary.solver.strips, needs(&scene(&json), Some(ModelLevel::Full)).raceway.strips);
            levels(&result)
        });
        let off = (tolerant[0] - whole[0]).abs().max((tolerant[1] - whole[1]).abs());
        println!("{name}: {off:.4} dB");
        assert!(off <= INTEGRATION, "{name}: {off}");
    }
}

/// Whatever the outputs, the tolerance and the terms that are on: drag and churning act wherever something fills the bearing.
#[test]
fn terms_stay_in_where_nothing_lets_them_go() {
    let all = |changes: Value, outputs: &Outputs| {
        ActiveTerms::of(&scene(&changed(article(), changes)), outputs, Some(ModelLevel::Full)).unwrap()
    };
    let ramp = json!([{ "at_s": 0, "rpm": 40_000 }, { "at_s": 1, "rpm": 50_000 }]);
    for changes in [
        json!({}),
        json!({ "terms": { "conformity": "on" } }),
        json!({ "terms": { "spin": "on" } }),
        json!({ "terms": { "drag": "on" } }),
        json!({ "terms": { "churning": "on" } }),
        json!({ "bearing": { "cage": { "film": "none" } } }),
        json!({ "operation": { "speed_rpm": ramp } }),
        json!({ "operation": { "speed_rpm": 1000 } }),
        json!({ "operation": { "radial_load_y_n": 5 } }),
        json!({ "operation": { "axial_load_n": 30 } }),
        json!({ "lubricant": { "traction": { "law": "four_parameter", "at_slip_m_s": 0.1 } } }),
        json!({ "operation": { "misalignment_mrad": { "y": 1, "z": 0 } } }),
    ] {
        for outputs in [levels_only(), settings().outputs] {
            let terms = all(changes.clone(), &outputs);
            assert!(terms.left_out.iter().all(|one| one.by != Justification::Judgement), "{changes}: {terms:?}");
            assert!(
                terms.drag && terms.churning && terms.raceway.conformity && terms.raceway.spin,
                "{changes}: {terms:?}"
            );
            assert!(terms.raceway.strips == if terms.raceway.gauss { 6 } else { 17 }, "{changes}: {terms:?}");
        }
    }
}

/// Where churning was once left out, and the repetition with all terms was off by 0.7 dB, that was taken for noise of the steps: a run
/// that does not change at tighter tolerances is not exact. The stated error holds.
#[test]
fn the_stated_error_of_a_slow_viscous_scene_holds() {
    let scene = scene(&changed(
        article(),
        json!({ "operation": { "speed_rpm": 10_000, "radial_load_y_n": 50 }, "lubricant": { "viscosity_pa_s": 0.2 } }),
    ));
    let all = simulate(&scene, &asked(0.0, levels_only()), &patient()).unwrap();
    let chosen = simulate(&scene, &asked(0.05, levels_only()), &patient()).unwrap();
    let stated = chosen.summary.accuracy.level_error_db().unwrap();
    for (all, chosen) in levels(&all).into_iter().zip(levels(&chosen)) {
        assert!((all - chosen).abs() < 0.05 && (all - chosen).abs() < 3.0 * stated + 1e-3, "{all} {chosen} {stated}");
    }
}
