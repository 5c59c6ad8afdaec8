//! What velocities of one component do to another by the transposed gradient, ∂/∂x_s (w ∂u_s/∂x_c).

use super::system::MomentumDiagonal;
use crate::metrics::Local;

/// Adds θ ν ∂/∂x_s (w ∂δ_s/∂x_c)/m to a component c, of increments δ_s of a component s whose halo and boundary faces are set.
pub(super) fn add_transposed(
    local: &Local,
    diagonal: MomentumDiagonal<'_>,
    [component, source]: [usize; 2],
    from: &[f64],
    to: &mut [f64],
) {
    let Some(weights) = diagonal.weights else { return };
    let (layout, strides, n) = (local.layout, local.layout.strides(), local.unknowns(component));
    let (along, across, share) = (strides[component], strides[source], diagonal.share(false));
    let weights = weights.edges[component][source];
    let (distances, widths) = (&local.axes[component].inverse_distance, &local.axes[source].inverse_width);
    let inverse = diagonal.inverse.map(|faces| faces.component(component));
    for k in 0..n[2] {
        for j in 0..n[1] {
            let start = layout.row(j, k);
            let entry = |axis: usize| local.entry([0, j, k][axis]);
            let (slope, width) = (entry(component), entry(source));
            let [x0, x1] = [start, start + along].map(|p| &from[p..p + n[0]]);
            let [x2, x3] = [start - across, start + along - across].map(|p| &from[p..p + n[0]]);
            let [high, low] = [start, start - across].map(|p| &weights[p..p + n[0]]);
            let out = &mut to[start..start + n[0]];
            for i in 0..n[0] {
                let slope = distances[if component == 0 { slope + i } else { slope }];
                let width = widths[if source == 0 { width + i } else { width }];
                let stress = high[i] * (x1[i] - x0[i]) - low[i] * (x3[i] - x2[i]);
                let inverse = inverse.map_or(diagonal.dt, |inverse| inverse[start + i]);
                out[i] += inverse * share * slope * width * stress;
            }
        }
    }
}
