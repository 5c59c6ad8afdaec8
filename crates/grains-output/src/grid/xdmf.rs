//! The XDMF grids of fields of cells.

use super::GridGeometry;
use crate::fields::{FieldSpec, Kind, Precision};
use crate::xdmf::{HyperSlab, Number, escaped, joined};
use std::fmt::Write;

/// What the XDMF file says.
pub(super) struct Sidecar<'a> {
    pub grid: &'a GridGeometry,
    pub specs: &'a [FieldSpec],
    pub precision: Precision,
}

impl Sidecar<'_> {
    /// The grid of a step at a time (s).
    pub fn text(&self, file: &str, step: usize, time: f64) -> String {
        let mut text = format!(
            "<Grid Name=\"cells\" GridType=\"Uniform\">\n<Time Value=\"{time:?}\"/>\n{}",
            self.mesh(file)
        );
        self.specs.iter().for_each(|spec| self.write_field(&mut text, file, step, spec));
        text + "</Grid>\n"
    }

    /// Topology and geometry; XDMF names z first, but for the coordinates of nodes.
    fn mesh(&self, file: &str) -> String {
        let cells = self.grid.cells();
        let nodes = joined(&[cells[2] + 1, cells[1] + 1, cells[0] + 1]);
        let number = Number::of(Kind::Real, Precision::F64).text();
        let items: Vec<String> = match self.grid.spacing() {
            Some(spacing) => [self.grid.nodes.each_ref().map(|nodes| nodes[0]), spacing]
                .map(|[x, y, z]| format!("Dimensions=\"3\" {number} Format=\"XML\">{z:?} {y:?} {x:?}"))
                .into(),
            None => std::iter::zip(cells, ["x", "y", "z"])
                .map(|(n, axis)| {
                    format!("Dimensions=\"{}\" {number} Format=\"HDF\">{file}:/grid/{axis}", n + 1)
                })
                .collect(),
        };
        let (topology, geometry) = match items.len() {
            2 => ("3DCoRectMesh", "ORIGIN_DXDYDZ"),
            _ => ("3DRectMesh", "VXVYVZ"),
        };
        let mut text = format!("<Topology TopologyType=\"{topology}\" Dimensions=\"{nodes}\"/>\n");
        let _ = writeln!(text, "<Geometry GeometryType=\"{geometry}\">");
        items.iter().for_each(|item| text += &format!("<DataItem {item}</DataItem>\n"));
        text + "</Geometry>\n"
    }

    fn write_field(&self, text: &mut String, file: &str, step: usize, spec: &FieldSpec) {
        let name = escaped(spec.name);
        let kind = if spec.components == 1 { "Scalar" } else { "Vector" };
        let _ = writeln!(text, "<Attribute Name=\"{name}\" AttributeType=\"{kind}\" Center=\"Cell\">");
        let [x, y, z] = self.grid.cells();
        // Scalars have no last dimension.
        let used = if spec.components == 1 { 4 } else { 5 };
        let slab = HyperSlab {
            array: &format!("/VTKHDF/CellData/{name}"),
            number: Number::of(spec.kind, self.precision),
            first: &[step, 0, 0, 0, 0][..used],
            count: &[1, z, y, x, spec.components][..used],
            whole: &[step + 1, z, y, x, spec.components][..used],
            // Without that of the steps: the reader wants as many dimensions as the mesh has.
            shape: &[z, y, x, spec.components][..used - 1],
        };
        slab.write(text, file);
        text.push_str("</Attribute>\n");
    }
}
