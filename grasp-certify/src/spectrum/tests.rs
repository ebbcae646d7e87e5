use super::*;
use crate::{Grasp, LinearLoop};
use grasp_plant::Parameters;

fn spectrum(feedback: LinearLoop, region: Region) -> Vec<Eigenvalue> {
    let function = Characteristic { grasp: Grasp::from(&Parameters::default()), feedback, kelvin_voigt: 0.0 };
    eigenvalues(&function, &region).expect("no eigenvalue on the border")
}

fn paper(feedback: LinearLoop) -> LinearLoop {
    feedback.with_uncertainties(&Grasp::from(&Parameters::default()), 0.1, 0.05)
}

/// Upper half of the region that holds the eigenvalues of the design notes.
const REGION: Region = Region { left: -103.7, right: 31.3, bottom: -1.37, top: 700.3 };

/// Each exact value occurs, to the digits given, and nothing else is in the region.
fn assert_spectrum(found: &[Eigenvalue], exact: &[(f64, f64)], tolerance: f64) {
    for (re, im) in exact {
        let near = found.iter().any(|e| (e.s - Complex::new(*re, *im)).abs() < tolerance * (1.0 + im.abs()));
        assert!(near, "{re} {im} not in {found:?}");
    }
    let upper: u32 = found.iter().filter(|e| e.s.im > -1e-9).map(|e| e.multiplicity).sum();
    assert_eq!(upper as usize, exact.len(), "{found:?}");
}

/// The loops of the paper, values of the design's table (mpmath, fifteen digits).
#[test]
fn the_papers_loops() {
    let pd = LinearLoop::pds([10.0, 9.0], [60.0; 2], [55.0; 2], [0.0; 2]);
    assert_spectrum(
        &spectrum(paper(pd), REGION),
        &[
            (-0.575_784_236_421_5, 0.0),
            (-1.087_654_806_108, 0.0),
            (-1.091_373_110_256, 0.0),
            (-35.952_565_158_46, 0.0),
            (-0.083_947_068_356, 561.340_888_192_2),
            (-86.753_323_903_7, 576.140_665_429_7),
        ],
        1e-9,
    );
    let pds = LinearLoop::pds([40.0, 35.0], [35.0; 2], [15.0; 2], [10.0; 2]);
    assert_spectrum(
        &spectrum(paper(pds), REGION),
        &[
            (-1.022_864_913_719, 0.0),
            (-3.123_915_537_211, 0.0),
            (-3.449_517_830_929, 0.0),
            (-95.583_728_685_28, 0.0),
            (-1.734_320_429_731, 558.727_469_393_3),
            (-91.692_755_221_6, 564.510_140_039_8),
        ],
        1e-9,
    );
}

/// The plant alone: two zeros at s = 0 (the grasp moves freely), and the free frequencies without uncertainties.
#[test]
fn the_free_grasp() {
    let region = Region { bottom: -1.37, ..REGION };
    let free = spectrum(LinearLoop::default(), region);
    assert_spectrum(
        &free.iter().copied().filter(|e| e.s.im > 1.0).collect::<Vec<_>>(),
        &[(0.0, 15.363_434_952_660), (0.0, 20.188_878_615_560), (0.0, 562.784_507_659_1), (0.0, 564.265_294_299_7)],
        1e-9,
    );
    let rigid: u32 = free.iter().filter(|e| e.s.abs() < 0.01).map(|e| e.multiplicity).sum();
    assert_eq!(rigid, 2);
    let damped = spectrum(paper(LinearLoop::default()), Region { left: -110.3, ..region });
    for (re, im) in [(-11.819_910_654_31, 9.846_575_085_34), (-15.761_872_350_17, 562.026_862_052_0)] {
        assert!(damped.iter().any(|e| (e.s - Complex::new(re, im)).abs() < 1e-7), "{damped:?}");
    }
}

/// PD without uncertainties removes the arms' moments and shears from hubs and object, so both arms vibrate as if clamped
/// and pinned: an undamped double eigenvalue at each frequency of `corrected::undamped_frequencies`.
#[test]
fn pd_leaves_the_beams_alone() {
    let pd = LinearLoop::pds([10.0, 9.0], [60.0; 2], [55.0; 2], [0.0; 2]);
    let found = spectrum(pd, REGION);
    let grasp = Grasp::from(&Parameters::default());
    let frequency = crate::corrected::undamped_frequencies(&grasp, 1)[0];
    let mode = found.iter().find(|e| e.s.im > 100.0).expect("a mode");
    // A double zero is found to the square root of rounding.
    assert!((mode.s - Complex::new(0.0, frequency)).abs() < 1e-3, "{found:?}");
    assert_eq!(mode.multiplicity, 2);
}
