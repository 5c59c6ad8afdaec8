//! Frames of a dump as VTK files of points, which ParaView opens as a series.

use crate::dump_file::Frame;
use crate::particles::Particle;
use std::io::{self, Write};

/// Columns that a vector of VTK holds, and its name.
const VECTORS: [([&str; 3], &str); 4] = [
    (["vx", "vy", "vz"], "velocity"),
    (["omegax", "omegay", "omegaz"], "angular_velocity"),
    (["fx", "fy", "fz"], "force"),
    (["tqx", "tqy", "tqz"], "torque"),
];

/// An array of point data.
struct Array {
    name: String,
    components: usize,
    values: Vec<f64>,
}

/// Writes a frame as VTK PolyData (`.vtp`): points in m; velocity, angular velocity, radius and quaternions (w, x, y, z) in SI units,
/// all other columns as they are.
///
/// # Errors
/// Those of writing.
pub fn write_vtp(out: &mut impl Write, frame: &Frame, particles: &[Particle]) -> io::Result<()> {
    let count = particles.len();
    let arrays = arrays(frame, particles);
    let points = Array {
        name: "Points".into(),
        components: 3,
        values: particles.iter().flat_map(|p| p.position).collect(),
    };
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>"
    )?;
    writeln!(out, "<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\">")?;
    let mut offset = 0;
    let mut declare = |out: &mut dyn Write, kind: &str, name: &str, components: usize, length: usize| {
        let size = offset;
        offset += 8 + 8 * length;
        writeln!(
            out,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{size}\"/>"
        )
    };
    writeln!(out, "<Points>")?;
    declare(out, "Float64", "Points", 3, points.values.len())?;
    writeln!(out, "</Points>\n<Verts>")?;
    declare(out, "Int64", "connectivity", 1, count)?;
    declare(out, "Int64", "offsets", 1, count)?;
    writeln!(out, "</Verts>\n<PointData>")?;
    for array in &arrays {
        declare(out, "Float64", &array.name, array.components, array.values.len())?;
    }
    write!(out, "</PointData>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
    block(out, points.values.len(), points.values.iter().map(|x| x.to_le_bytes()))?;
    block(out, count, (0..count as i64).map(i64::to_le_bytes))?;
    block(out, count, (1..=count as i64).map(i64::to_le_bytes))?;
    for array in &arrays {
        block(out, array.values.len(), array.values.iter().map(|x| x.to_le_bytes()))?;
    }
    write!(out, "\n</AppendedData>\n</VTKFile>\n")
}

/// A block of appended data: its size in bytes, and numbers of 8 bytes.
fn block(out: &mut impl Write, count: usize, mut numbers: impl Iterator<Item = [u8; 8]>) -> io::Result<()> {
    out.write_all(&(8 * count as u64).to_le_bytes())?;
    numbers.try_for_each(|bytes| out.write_all(&bytes))
}

fn arrays(frame: &Frame, particles: &[Particle]) -> Vec<Array> {
    let mut arrays = Vec::new();
    let mut taken = vec!["x", "y", "z", "radius", "quat1", "quat2", "quat3", "quat4"];
    let mut add = |name: &str, components: usize, values: Vec<f64>| {
        arrays.push(Array { name: name.to_owned(), components, values });
    };
    if particles.iter().any(|p| p.radius.is_some()) {
        add("radius", 1, particles.iter().map(|p| p.radius.unwrap_or(0.0)).collect());
    }
    if particles.iter().any(|p| p.orientation.is_some()) {
        let unturned = [1.0, 0.0, 0.0, 0.0];
        let turns = particles.iter().flat_map(|p| p.orientation.unwrap_or(unturned)).collect();
        add("orientation_wxyz", 4, turns);
    }
    for (columns, name) in VECTORS {
        let Some(places) = frame.columns.iter().position(|c| c == columns[0]).and_then(|first| {
            let rest = [frame.column(columns[1])?, frame.column(columns[2])?];
            Some([first, rest[0], rest[1]])
        }) else {
            continue;
        };
        taken.extend(columns);
        let values = match name {
            "velocity" => particles.iter().flat_map(|p| p.velocity).collect(),
            "angular_velocity" => particles.iter().flat_map(|p| p.angular_velocity).collect(),
            _ => frame.rows.iter().flat_map(|row| places.map(|k| row[k])).collect(),
        };
        add(name, 3, values);
    }
    for (k, column) in frame.columns.iter().enumerate().filter(|(_, c)| !taken.contains(&c.as_str())) {
        let plain: String =
            column.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '_' }).collect();
        add(&plain, 1, frame.rows.iter().map(|row| row[k]).collect());
    }
    arrays
}

/// Writes the series of frames (`.pvd`): times (s, or steps where the dump has no times) and files.
///
/// # Errors
/// Those of writing.
pub fn write_pvd(out: &mut impl Write, frames: &[(f64, String)]) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>")?;
    for (time, file) in frames {
        writeln!(out, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>")?;
    }
    writeln!(out, "</Collection>\n</VTKFile>")
}
