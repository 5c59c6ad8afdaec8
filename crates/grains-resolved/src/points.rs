//! Points on the surfaces of bodies, evenly apart as far as the shape allows, with all edges and corners
//! (Rakotonirina 2016, 7.3.4).

use grains_geometry::{Core, Part, Polyhedron, Shape, Superellipsoid, Vec3};
use std::f64::consts::PI;

/// Points are dropped that lie closer than this to another one of an equal or sharper feature (spacings).
const CLOSEST: f64 = 0.6;
/// Points on faces keep this distance from their edges (spacings).
const MARGIN: f64 = 0.6;
/// Points of a dense cover are thinned to this distance, so that those left are a spacing apart on average (spacings).
const EVEN: f64 = 0.85;
/// Candidates on a curved surface per point that is kept.
const CANDIDATES: f64 = 6.0;

/// A point on the surface of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Place in the body frame (m).
    pub place: Vec3,
    /// Outward unit normal; on edges and corners the mean of those around.
    pub normal: Vec3,
}

/// What a candidate lies on: sharper features come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Feature {
    Corner,
    Edge,
    Face,
}

struct Candidate {
    point: SurfacePoint,
    feature: Feature,
}

/// Points on the surface of a shape at scale 1, about `spacing` (m) apart.
///
/// Parts of a composite are covered one by one; points inside another part are left out, and of those closer than 0.6
/// spacings the sharper feature stays. With `across`, a unit vector of the body frame, the points lie on the outline of the
/// section through the centre normal to it, for prisms, cylinders along it, and spheres.
pub fn surface_points(shape: &Shape, spacing: f64, across: Option<&Vec3>) -> Vec<SurfacePoint> {
    let mut candidates = Vec::new();
    for (k, part) in shape.parts.iter().enumerate() {
        let turned = across.map(|axis| part.rotation.tr_mul(axis));
        for mut candidate in of_part(part, spacing, turned.as_ref()) {
            let point = &mut candidate.point;
            point.place = part.rotation * point.place + part.center;
            point.normal = part.rotation * point.normal;
            let outside = point.place + point.normal * (1e-6 * shape.bounding_radius);
            let is_hidden = |other: &Part| other.contains(&other.rotation.tr_mul(&(outside - other.center)));
            let mut others = shape.parts.iter().enumerate().filter(|(m, _)| *m != k).map(|(_, part)| part);
            if !others.any(is_hidden) {
                candidates.push(candidate);
            }
        }
    }
    thinned(candidates, CLOSEST * spacing)
}

/// Drops points too close to others; normals of points at one place are averaged.
fn thinned(mut candidates: Vec<Candidate>, closest: f64) -> Vec<SurfacePoint> {
    candidates.sort_by_key(|c| c.feature);
    let mut kept: Vec<SurfacePoint> = Vec::new();
    for Candidate { point, .. } in candidates {
        let near = kept.iter_mut().find(|k| (k.place - point.place).norm_squared() < closest * closest);
        match near {
            None => kept.push(point),
            Some(same) if (same.place - point.place).norm() < 1e-6 * closest => same.normal += point.normal,
            Some(_) => {}
        }
    }
    let unit =
        |point: SurfacePoint| Some(SurfacePoint { normal: point.normal.try_normalize(1e-9)?, ..point });
    kept.into_iter().filter_map(unit).collect()
}

fn of_part(part: &Part, spacing: f64, across: Option<&Vec3>) -> Vec<Candidate> {
    match &part.core {
        Core::Point => match across {
            None => sphere(part.crust, spacing),
            Some(axis) => {
                let [e, f] = plane(axis);
                ring(&Vec3::zeros(), &e, &f, part.crust, spacing, 0.0, Feature::Face)
            }
        },
        Core::Box(half) => {
            let half = half.add_scalar(part.crust);
            let corner = |k: usize| Vec3::from_fn(|a, _| if k >> a & 1 == 0 { -half[a] } else { half[a] });
            // Corners of each face in order around it.
            let faces = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
            polyhedron(&faces.map(|loop_| loop_.map(corner).to_vec()), spacing, across)
        }
        Core::Cylinder { radius, half_height } => {
            cylinder(radius + part.crust, half_height + part.crust, spacing, across)
        }
        Core::Segment { .. } | Core::Cone(_) => by_rays(part, spacing, across),
        Core::Polyhedron(hull) => polyhedron(&sharp_faces(hull, part.crust), spacing, across),
        Core::Triangle(_) => Vec::new(),
        Core::Superellipsoid(body) => superellipsoid(&body.sharp(), spacing, across),
    }
}

/// Two unit vectors that span the plane normal to an axis.
fn plane(axis: &Vec3) -> [Vec3; 2] {
    let smallest = axis.iamin();
    let mut other = Vec3::zeros();
    other[smallest] = 1.0;
    let e = axis.cross(&other).normalize();
    [e, axis.cross(&e)]
}

/// Points of a spiral that goes round from pole to pole: nearly a hexagonal lattice everywhere.
fn spiral(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    })
}

fn sphere(radius: f64, spacing: f64) -> Vec<Candidate> {
    // A hexagonal lattice has √3/2 of a square per point.
    let count = (4.0 * PI * radius * radius / (0.75_f64.sqrt() * spacing * spacing)).round().max(6.0);
    let at = |normal: Vec3| Candidate {
        point: SurfacePoint { place: normal * radius, normal },
        feature: Feature::Face,
    };
    spiral(count as usize).map(at).collect()
}

fn ring(
    center: &Vec3,
    e: &Vec3,
    f: &Vec3,
    radius: f64,
    spacing: f64,
    phase: f64,
    feature: Feature,
) -> Vec<Candidate> {
    let count = (2.0 * PI * radius / spacing).round().max(3.0);
    let at = |k: usize| {
        let (sin, cos) = (2.0 * PI * (k as f64 + phase) / count).sin_cos();
        let normal = e * cos + f * sin;
        Candidate { point: SurfacePoint { place: center + normal * radius, normal }, feature }
    };
    (0..count as usize).map(at).collect()
}

/// Rings along the axis, those at the ends on the edges, and rings on the end discs.
fn cylinder(radius: f64, half: f64, spacing: f64, across: Option<&Vec3>) -> Vec<Candidate> {
    let [e, f] = [Vec3::x(), Vec3::y()];
    if let Some(axis) = across {
        if axis.z.abs() > 0.5 {
            return ring(&Vec3::zeros(), &e, &f, radius, spacing, 0.0, Feature::Face);
        }
        let side = axis.cross(&Vec3::z()) * radius;
        let end = Vec3::z() * half;
        return outline(&[side + end, end - side, -side - end, side - end], spacing);
    }
    let rings = (2.0 * half / spacing).round().max(1.0) as usize;
    let mut points = Vec::new();
    for k in 0..=rings {
        let z = half * (2.0 * k as f64 / rings as f64 - 1.0);
        let is_end = k == 0 || k == rings;
        let feature = if is_end { Feature::Edge } else { Feature::Face };
        let phase = if k % 2 == 0 { 0.0 } else { 0.5 };
        let mut around = ring(&(Vec3::z() * z), &e, &f, radius, spacing, phase, feature);
        if is_end {
            let up = Vec3::z() * z.signum();
            around.iter_mut().for_each(|c| c.point.normal = (c.point.normal + up).normalize());
        }
        points.extend(around);
    }
    let discs = (radius / spacing).round().max(1.0) as usize;
    for up in [Vec3::z(), -Vec3::z()] {
        for k in 0..discs {
            let r = radius * k as f64 / discs as f64;
            let center = up * half;
            let mut around = if k == 0 {
                let point = SurfacePoint { place: center, normal: up };
                vec![Candidate { point, feature: Feature::Face }]
            } else {
                ring(&center, &e, &f, r, spacing, 0.5 * (k % 2) as f64, Feature::Face)
            };
            around.iter_mut().for_each(|c| c.point.normal = up);
            points.extend(around);
        }
    }
    points
}

/// The faces of a hull, as loops of corners, before it was eroded by a crust.
fn sharp_faces(hull: &Polyhedron, crust: f64) -> Vec<Vec<Vec3>> {
    let corner = |v: usize| {
        // Where the faces around the vertex meet when moved outwards.
        let around = hull.faces().iter().filter(|face| face.vertices.iter().any(|&w| w as usize == v));
        let (mut matrix, mut right) = (grains_geometry::Mat3::zeros(), Vec3::zeros());
        for face in around {
            matrix += face.normal * face.normal.transpose();
            right += face.normal * (face.offset + crust);
        }
        matrix.try_inverse().map_or(hull.vertices()[v], |inverse| inverse * right)
    };
    let corners: Vec<Vec3> = (0..hull.vertices().len()).map(corner).collect();
    let of_face = |face: &grains_geometry::Face| {
        face.vertices.iter().map(|&v| corners[v as usize]).collect::<Vec<Vec3>>()
    };
    hull.faces().iter().map(of_face).collect()
}

fn polyhedron(faces: &[Vec<Vec3>], spacing: f64, across: Option<&Vec3>) -> Vec<Candidate> {
    let middle = |corners: &[Vec3]| corners.iter().sum::<Vec3>() / corners.len() as f64;
    if let Some(axis) = across {
        // A prism: one of its ends is the section.
        let end = faces.iter().find(|corners| outward(corners).dot(axis) > 0.999);
        return end.map_or(Vec::new(), |corners| {
            let flat: Vec<Vec3> = corners.iter().map(|c| c - axis * axis.dot(c)).collect();
            outline(&flat, spacing)
        });
    }
    let mut points = Vec::new();
    for corners in faces {
        let normal = outward(corners);
        let at = |place: Vec3, feature: Feature| Candidate { point: SurfacePoint { place, normal }, feature };
        for (k, &start) in corners.iter().enumerate() {
            let end = corners[(k + 1) % corners.len()];
            points.push(at(start, Feature::Corner));
            let steps = ((end - start).norm() / spacing).round().max(1.0) as usize;
            let along = |m: usize| start + (end - start) * (m as f64 / steps as f64);
            points.extend((1..steps).map(|m| at(along(m), Feature::Edge)));
        }
        points.extend(inside(corners, &normal, &middle(corners), spacing).map(|p| at(p, Feature::Face)));
    }
    points
}

/// Outward normal of a face of a body about the origin.
fn outward(corners: &[Vec3]) -> Vec3 {
    let mut normal = Vec3::zeros();
    for k in 0..corners.len() {
        normal += corners[k].cross(&corners[(k + 1) % corners.len()]);
    }
    let unit = normal.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    if unit.dot(&corners[0]) < 0.0 { -unit } else { unit }
}

/// A square lattice along the first edge, of the points within a convex face away from its edges.
fn inside<'a>(
    corners: &'a [Vec3],
    normal: &Vec3,
    middle: &Vec3,
    spacing: f64,
) -> impl Iterator<Item = Vec3> + 'a {
    let e = (corners[1] - corners[0]).normalize();
    let f = normal.cross(&e);
    let (middle, reach) = (*middle, corners.iter().map(|c| (c - middle).norm()).fold(0.0, f64::max));
    let edges: Vec<(Vec3, Vec3)> = (0..corners.len())
        .map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            let across = normal.cross(&(b - a)).normalize();
            (a, if across.dot(&(middle - a)) < 0.0 { -across } else { across })
        })
        .collect();
    // The lattice begins on the first corner, as the points on its edges do.
    let steps = (2.0 * reach / spacing).ceil() as i64;
    let lattice = (-steps..=steps).flat_map(move |j| (-steps..=steps).map(move |i| (i, j)));
    let first = corners[0];
    let pitch = |length: f64| length / (length / spacing).round().max(1.0);
    let along = pitch((corners[1] - corners[0]).norm());
    let up = pitch((corners[corners.len() - 1] - corners[0]).dot(&f).abs().max(spacing));
    lattice
        .map(move |(i, j)| first + e * (i as f64 * along) + f * (j as f64 * up))
        .filter(move |p| edges.iter().all(|(a, inwards)| inwards.dot(&(p - a)) > MARGIN * spacing))
}

/// Points on the edges of a convex polygon in its plane.
fn outline(corners: &[Vec3], spacing: f64) -> Vec<Candidate> {
    let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
    let mut points = Vec::new();
    for (k, &start) in corners.iter().enumerate() {
        let end = corners[(k + 1) % corners.len()];
        let along = (end - start).normalize();
        let away = start - middle;
        let normal = (away - along * along.dot(&away)).normalize();
        let steps = ((end - start).norm() / spacing).round().max(1.0) as usize;
        for m in 0..=steps {
            let place = start + (end - start) * (m as f64 / steps as f64);
            let feature = if m == 0 || m == steps { Feature::Corner } else { Feature::Edge };
            points.push(Candidate { point: SurfacePoint { place, normal }, feature });
        }
    }
    points
}

fn superellipsoid(body: &Superellipsoid, spacing: f64, across: Option<&Vec3>) -> Vec<Candidate> {
    covered(body.semi_axes().norm(), spacing, across, |direction| {
        let (gauge, gradient) = body.gauge(&direction);
        Some(SurfacePoint { place: direction / gauge, normal: gradient.try_normalize(0.0)? })
    })
}

/// The body seen from the origin of its frame.
fn by_rays(part: &Part, spacing: f64, across: Option<&Vec3>) -> Vec<Candidate> {
    covered(part.half_extents.norm(), spacing, across, |direction| {
        let (place, normal) = part.surface_along(&direction)?;
        Some(SurfacePoint { place, normal })
    })
}

/// Candidates all over the surface of a body of a size (m), of which thinning keeps an even few; `seen` is the point of
/// the surface in a direction.
fn covered(
    size: f64,
    spacing: f64,
    across: Option<&Vec3>,
    seen: impl Fn(Vec3) -> Option<SurfacePoint>,
) -> Vec<Candidate> {
    let on_surface = |direction: Vec3| Some(Candidate { point: seen(direction)?, feature: Feature::Face });
    match across {
        None => {
            let count = CANDIDATES * CANDIDATES * 4.0 * PI * (size / spacing).powi(2);
            let thin = thinned(spiral(count as usize).filter_map(on_surface).collect(), EVEN * spacing);
            thin.into_iter().map(|point| Candidate { point, feature: Feature::Face }).collect()
        }
        Some(axis) => {
            let [e, f] = plane(axis);
            let count = (CANDIDATES * CANDIDATES * 2.0 * PI * size / spacing) as usize;
            let around = (0..count).map(|k| {
                let (sin, cos) = (2.0 * PI * k as f64 / count as f64).sin_cos();
                e * cos + f * sin
            });
            let thin = thinned(around.filter_map(on_surface).collect(), EVEN * spacing);
            thin.into_iter().map(|point| Candidate { point, feature: Feature::Face }).collect()
        }
    }
}
