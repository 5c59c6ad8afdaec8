//! The drag law that docs/develop/drag-law.md adds as an example: what its file would hold, and its test.

use grains_coupling::{DragLaw, Flow, ShapeFactors};

/// F = ε ((1 + 0.15 Re^0.687 + 5.81 φ)/ε³ + 0.48 φ^⅓/ε⁴ + φ³ Re (0.95 + 0.61 φ³/ε²)), φ = 1 − ε (Tenneti, Garg and Subramaniam 2011).
fn resistance(flow: &Flow) -> f64 {
    let Flow { reynolds, void_fraction: eps, .. } = *flow;
    let phi = 1.0 - eps;
    let alone = 1.0 + 0.15 * reynolds.powf(0.687);
    let crowded = 5.81 * phi / eps.powi(3) + 0.48 * phi.cbrt() / eps.powi(4);
    let inertial = phi.powi(3) * reynolds * (0.95 + 0.61 * phi.powi(3) / eps.powi(2));
    eps * (alone / eps.powi(3) + crowded + inertial)
}

#[test]
fn it_is_that_of_a_lone_sphere_and_near_beetstra_in_beds() {
    for reynolds in [0.1, 10.0, 100.0] {
        let flow = |void_fraction| Flow { reynolds, void_fraction, shape: ShapeFactors::SPHERE };
        let alone = DragLaw::SchillerNaumann.resistance(&flow(1.0));
        assert!((resistance(&flow(1.0)) / alone - 1.0).abs() < 1e-12);
        let bed = DragLaw::Beetstra.resistance(&flow(0.6));
        assert!(
            (resistance(&flow(0.6)) / bed - 1.0).abs() < 0.2,
            "{reynolds}: {} {bed}",
            resistance(&flow(0.6))
        );
    }
}
