use super::*;
use crate::settings::Settings;
use grasp_plant::Parameters;

fn paper() -> Grasp {
    Grasp::from(&Parameters::default())
}

/// The gains of the control notes: κ = 20, root strain σ, G = 8, everything fed forward.
pub(crate) fn ports(sigma: f64, reach: f64) -> [Port; 3] {
    let hub = Port {
        inertia: 0.0073,
        assumed_inertia: 0.0073,
        slope: 8.0,
        reach,
        strain: sigma,
        feedforward: 1.0,
        observer: 0.0,
        load_rate: 0.0,
    };
    [hub, hub, Port { inertia: 0.5, assumed_inertia: 0.5, strain: 20.0, ..hub }]
}

/// The storage functions of the control notes, V = ½(G/c)p² + ½ m s².
fn plain(ports: &[Port; 3], epsilon_1: f64, epsilon_2: f64, tau: f64) -> Constants {
    let storage = ports.map(|port| Storage::plain([port.slope / port.strain, port.inertia, port.slope]));
    Constants { epsilon_1, epsilon_2, tau: [tau; 2], storage }
}

fn size(size: [f64; 3]) -> Disturbance {
    Disturbance { size, rate: [0.0; 3] }
}

/// The results of a norm-wise 10 × 10 comparison with the same constants, 4.592 and 5.859 1/s (all sign patterns), and of
/// an independent mpmath evaluation of this form (`tests/test_certificates.py`): 4.9127 and 7.7327, for reach without
/// bound.
#[test]
fn the_notes_gains_are_certified() {
    let grasp = paper();
    for (sigma, constants, least) in
        [(40.0, (23.017_85, 7.143_89, 93.994_6), 4.9127), (100.0, (39.465_6, 6.795_65, 119.106_4), 7.7327)]
    {
        let ports = ports(sigma, 1e6);
        let constants = plain(&ports, constants.0, constants.1, constants.2);
        let certificate = verify(&grasp, &ports, &constants, least).expect("certified");
        assert!(certificate.phi > least * (1.0 - 1e-6) && certificate.theta > 0.1, "{certificate:?}");
        // The limit is at this place, not far below.
        assert!(verify(&grasp, &ports, &constants, 1.01 * least).is_none());
    }
}

/// With full feed-forward and known inertias the natural storage is that of the notes.
#[test]
fn natural_storage_is_that_of_the_notes() {
    for port in ports(40.0, 50.0) {
        let found = port.natural_storage();
        for (found, exact) in found.iter().zip([port.slope / port.strain, port.inertia, port.slope]) {
            assert!((found - exact).abs() < 1e-12 * exact, "{found} {exact}");
        }
    }
}

/// The search is at least as good as the plain storage functions, also with partial feed-forward, with a wrong inertia and
/// with unequal arms.
#[test]
fn searches_find_certificates() {
    let mut grasp = paper();
    let found = certify(&grasp, &ports(40.0, 50.0)).expect("certified");
    assert!(found.phi > 4.8, "{}", found.phi);
    let mut part = ports(40.0, 50.0).map(|port| Port { feedforward: 0.4, ..port });
    assert!(certify(&grasp, &part).expect("certified").phi > 1.0);
    part[2].assumed_inertia = 0.3;
    assert!(certify(&grasp, &part).is_some());
    grasp.arms[1].ei = 0.2;
    grasp.arms[0].rho = 0.03;
    assert!(certify(&grasp, &part).is_some());
    part[0].feedforward = 0.0;
    assert!(certify(&grasp, &part).is_none());
    // The built-in uncertainty replaces the missing feed-forward.
    part[0].load_rate = 0.02;
    assert!(certify(&grasp, &part).is_some());
}

/// Bounds scale correctly: W with the square of the disturbance, errors linearly; they are zero without disturbance.
#[test]
fn bounds_follow_the_disturbance() {
    let (grasp, ports) = (paper(), ports(40.0, 50.0));
    let constants = plain(&ports, 23.0, 7.1, 94.0);
    let certificate = verify(&grasp, &ports, &constants, 4.0).expect("certified");
    let one = certificate.ultimate(&grasp, &ports, &size([0.0, 0.01, 0.01]));
    let two = certificate.ultimate(&grasp, &ports, &size([0.0, 0.02, 0.02]));
    assert!((two.energy / one.energy - 4.0).abs() < 1e-9 && (two.position / one.position - 2.0).abs() < 1e-9);
    assert_eq!(certificate.ultimate(&grasp, &ports, &Disturbance::default()).energy, 0.0);
    // D² = ΣBΔ²/m², by hand.
    let drive = certificate.drive(&ports, &size([0.0, 0.01, 0.01]));
    assert!((drive.powi(2) - 1e-4 * (1.0 / 0.0073 + 1.0 / 0.5)).abs() < 1e-9 * drive.powi(2));
    let energy = certificate.energy_at_rest(&grasp, &ports, [0.0, 0.0], 1e-3);
    let now = certificate.implied(&grasp, energy);
    assert!(now.position >= 1e-3 && now.force[0] >= grasp.tip_stiffness(0) * 1e-3);
}

/// Leakage lowers the rate as its formula says, and no leakage changes nothing.
#[test]
fn leakage_has_its_price() {
    let (grasp, ports) = (paper(), ports(40.0, 50.0));
    let certificate = verify(&grasp, &ports, &plain(&ports, 23.0, 7.1, 94.0), 4.0).expect("certified");
    let mass = |gain: f64, leakage: f64| Estimator { name: "m_hat".into(), gain, leakage, size: 0.5 };
    let slow = certificate.with_leakage(&grasp, vec![mass(10.0, 0.1), mass(0.0, 1.0)]);
    assert_eq!((slow.estimators.len(), slow.phi), (1, 1.0));
    assert!((slow.ultimate.energy - 0.0125 / certificate.theta).abs() < 1e-12);
    assert_eq!(certificate.with_leakage(&grasp, vec![]).ultimate.energy, 0.0);
}

/// The shipped preset *certified* is proved: with its observers, with and without the uncertainties of Section IV. No
/// certificate of this kind exists for the preset *fast*.
#[test]
fn presets_are_certified_or_cannot_be() {
    let grasp = paper();
    let mut settings = Settings::default();
    settings.set_preset("certified").unwrap();
    for uncertainties in [[0.0; 2], [0.1, 0.05]] {
        [settings.plant.root_uncertainty, settings.plant.tip_uncertainty] = uncertainties;
        let ports = settings.ports().unwrap();
        assert!(ports.iter().all(|port| port.observer > 0.0) && obstacle(&grasp, &ports).is_none());
        let certificate = certify(&grasp, &ports).expect("certified");
        assert!(certificate.phi > 1.0, "{uncertainties:?} {}", certificate.phi);
        // Observers remove constant disturbances completely, but not changing ones.
        let slow = Disturbance { size: [0.0; 3], rate: [0.0, 0.0, 0.01] };
        assert!(certificate.ultimate(&grasp, &ports, &slow).energy > 0.0);
    }
    settings.set_preset("fast").unwrap();
    let ports = settings.ports().unwrap().map(Port::without_observer);
    let obstacle = obstacle(&grasp, &ports).expect("fast has too little root strain");
    assert!(obstacle.value > obstacle.limit && certify(&grasp, &ports).is_none());
}

/// Just beyond the obstacle's limit no search succeeds; well below it one does, so the condition is not far from necessary
/// and sufficient.
#[test]
fn the_obstacle_is_real() {
    let grasp = paper();
    // K = (3/2)x²/(x + y) with x = G_i/σ_i, y = G/κ in rates.
    let with = |slope: f64| {
        let mut all = ports(2.9 * 20.0, 50.0);
        for hub in &mut all[..2] {
            hub.slope = slope;
        }
        all
    };
    let limit = (1..2000).map(|i| 0.1 * f64::from(i)).find(|g| obstacle(&grasp, &with(*g)).is_some()).unwrap();
    assert!(certify(&grasp, &with(limit)).is_none());
    assert!(certify(&grasp, &with(0.3 * limit)).is_some(), "{limit}");
}
