//! Numbers of one query, or of several side by side in the lanes of the processor.

use crate::{Mat3, Vec3, powers};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Queries side by side: a whole number of times the lanes of any processor.
pub const LANES: usize = 8;

/// A number of one query, or of each of several.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The same number for all.
    fn of(x: f64) -> Self;
    /// The number of one of the queries.
    fn lane(self, lane: usize) -> f64;
    /// The largest whole number not above a number from 0 on.
    fn whole(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The number without its sign.
    fn abs(self) -> Self;
    /// Binary logarithm of a positive normal number.
    fn log2(self) -> Self;
    /// Power of two.
    fn exp2(self) -> Self;
    /// One of two numbers: the first where this one is above another.
    fn if_above(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// One of two numbers: the first where this one equals another.
    fn if_equal(self, other: Self, then: Self, otherwise: Self) -> Self;
}

/// Numbers of queries side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    #[inline(always)]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for x in &mut self.0 {
            *x = f(*x);
        }
        self
    }

    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (x, y) in self.0.iter_mut().zip(&other.0) {
            *x = f(*x, *y);
        }
        self
    }

    #[inline(always)]
    fn select(
        self,
        other: Self,
        (then, mut otherwise): (Self, Self),
        holds: impl Fn(f64, f64) -> bool,
    ) -> Self {
        for (lane, found) in otherwise.0.iter_mut().enumerate() {
            *found = if holds(self.0[lane], other.0[lane]) { then.0[lane] } else { *found };
        }
        otherwise
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |x, y| x + y)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |x, y| x - y)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |x, y| x * y)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |x, y| x / y)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self.map(f64::floor)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn log2(self) -> Self {
        Self(powers::log2(self.0))
    }

    #[inline(always)]
    fn exp2(self) -> Self {
        Self(powers::exp2(self.0))
    }

    #[inline(always)]
    fn if_above(self, other: Self, then: Self, otherwise: Self) -> Self {
        self.select(other, (then, otherwise), |x, y| x > y)
    }

    #[inline(always)]
    fn if_equal(self, other: Self, then: Self, otherwise: Self) -> Self {
        self.select(other, (then, otherwise), |x, y| x == y)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self as u64 as f64
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn log2(self) -> Self {
        powers::log2([self])[0]
    }

    #[inline(always)]
    fn exp2(self) -> Self {
        powers::exp2([self])[0]
    }

    #[inline(always)]
    fn if_above(self, other: Self, then: Self, otherwise: Self) -> Self {
        if self > other { then } else { otherwise }
    }

    #[inline(always)]
    fn if_equal(self, other: Self, then: Self, otherwise: Self) -> Self {
        if self == other { then } else { otherwise }
    }
}

/// A number to a natural power, by repeated squaring.
#[inline(always)]
pub(crate) fn natural<T: Number>(x: T, mut exponent: u32) -> T {
    let (mut power, mut square) = (T::of(1.0), x);
    while exponent > 0 {
        if exponent & 1 == 1 {
            power = power * square;
        }
        square = square * square;
        exponent >>= 1;
    }
    power
}

/// A vector of such numbers.
#[derive(Clone, Copy, Debug)]
pub struct Vector<T>(pub [T; 3]);

impl<T: Number> Vector<T> {
    /// The same vector for all.
    #[inline(always)]
    pub fn of(v: &Vec3) -> Self {
        Self([T::of(v.x), T::of(v.y), T::of(v.z)])
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(&self, Self([p, q, r]): &Self) -> T {
        let [x, y, z] = self.0;
        x * *p + y * *q + z * *r
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(&self, Self([p, q, r]): &Self) -> Self {
        let [x, y, z] = self.0;
        Self([y * *r - z * *q, z * *p - x * *r, x * *q - y * *p])
    }

    /// Sum.
    #[inline(always)]
    pub fn plus(&self, Self([p, q, r]): &Self) -> Self {
        let [x, y, z] = self.0;
        Self([x + *p, y + *q, z + *r])
    }

    /// Difference.
    #[inline(always)]
    pub fn minus(&self, Self([p, q, r]): &Self) -> Self {
        let [x, y, z] = self.0;
        Self([x - *p, y - *q, z - *r])
    }

    /// The vector times a number.
    #[inline(always)]
    pub fn times(&self, factor: T) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }

    /// Square of the length.
    #[inline(always)]
    pub fn squared(&self) -> T {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    pub fn norm(&self) -> T {
        self.squared().sqrt()
    }

    /// Products of the components.
    #[inline(always)]
    pub fn by_component(&self, Self([p, q, r]): &Self) -> Self {
        let [x, y, z] = self.0;
        Self([x * *p, y * *q, z * *r])
    }

    /// Sum of the components without signs.
    #[inline(always)]
    pub fn sum_of_sizes(&self) -> T {
        let [x, y, z] = self.0;
        x.abs() + y.abs() + z.abs()
    }

    /// One of two vectors: the first where a number is above another.
    #[inline(always)]
    pub fn if_above((number, other): (T, T), then: &Self, otherwise: &Self) -> Self {
        let [x, y, z] = then.0;
        let [p, q, r] = otherwise.0;
        let pick = |then, otherwise| number.if_above(other, then, otherwise);
        Self([pick(x, p), pick(y, q), pick(z, r)])
    }
}

/// A matrix of such numbers, by columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Matrix<T>(pub(crate) [Vector<T>; 3]);

impl<T: Number> Matrix<T> {
    /// The product with a vector.
    #[inline(always)]
    pub(crate) fn times(&self, Vector([x, y, z]): &Vector<T>) -> Vector<T> {
        let [p, q, r] = &self.0;
        p.times(*x).plus(&q.times(*y)).plus(&r.times(*z))
    }

    /// That of a placement, by one query.
    #[inline(always)]
    pub(crate) fn of(matrix: &Mat3) -> Self {
        Self([0, 1, 2].map(|k| Vector::of(&matrix.column(k).into_owned())))
    }

    /// The product of the transposed matrix with a vector.
    #[inline(always)]
    pub(crate) fn transposed_times(&self, v: &Vector<T>) -> Vector<T> {
        let [p, q, r] = &self.0;
        Vector([p.dot(v), q.dot(v), r.dot(v)])
    }
}

impl Vector<Lanes> {
    /// Sets the vector of a query.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: &Vec3) {
        for axis in 0..3 {
            self.0[axis].0[lane] = v[axis];
        }
    }

    /// The vector of a query.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        let Self([x, y, z]) = self;
        Vec3::new(x.0[lane], y.0[lane], z.0[lane])
    }
}

impl Matrix<Lanes> {
    /// Sets the matrix of a query.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, matrix: &Mat3) {
        for (column, of) in self.0.iter_mut().zip(matrix.column_iter()) {
            column.set(lane, &of.into_owned());
        }
    }
}

impl Vector<f64> {
    #[inline(always)]
    pub(crate) fn get(&self) -> Vec3 {
        Vec3::from(self.0)
    }
}
