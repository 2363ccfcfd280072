//! One formula for one ball or for several side by side.
//!
//! A formula is written once, for one ball. Where many balls need it, it runs over columns of numbers, [`Lanes`], in a
//! loop whose body has no branch and whose iterations are independent. The compiler then lays the balls side by side in
//! the registers of the processor: two, four or eight at once, by the instruction set that [`InstructionSet::run`]
//! compiles for. Rust never contracts or reorders sums of floats, so that the bits are the same on all of them. In
//! single precision, [`Singles`], a register holds twice as many. A loop over both precisions is limited by the wider
//! numbers, so that conversions stand in loops of their own.
//!
//! Such loops may contain: + − × ÷, √, comparisons that choose a value, own functions made of these
//! (`exponential`, `angle`). A call into the platform's mathematics or an early return prevents vectorization. So do
//! constants read through a reference, which a store might change; a copy of them stands before the loop. `cargo bench
//! --bench contact` shows whether balls are side by side.

use std::fmt;
use std::ops::{Add, Div, Index, IndexMut, Mul, Neg, Sub};

/// Balls that stand side by side: one register of AVX-512, two of AVX2, four of SSE2. The same on every machine, so that
/// sums, and with them bits, are the same, too.
pub const LANES: usize = 8;

/// A number of each of `N` balls.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const N: usize = LANES, T = f64>(pub [T; N]);

/// Lanes in single precision, where seven digits are enough.
pub(crate) type Singles = Lanes<LANES, f32>;

/// Number type of the formulas: double or single precision.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The number nearest to a constant.
    fn of(constant: f64) -> Self;
    fn sqrt(self) -> Self;
}

macro_rules! real {
    ($number:ty) => {
        impl Real for $number {
            #[inline(always)]
            fn of(constant: f64) -> Self {
                constant as Self
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
        }
    };
}
real!(f32);
real!(f64);

impl<const N: usize, T: Copy + Default> Lanes<N, T> {
    /// The same number for all.
    #[inline(always)]
    pub fn all(value: T) -> Self {
        Self([value; N])
    }

    /// `N` numbers of a list, from `first` on.
    #[inline(always)]
    pub fn of(list: &[T], first: usize) -> Self {
        let mut lanes = [T::default(); N];
        lanes.copy_from_slice(&list[first..first + N]);
        Self(lanes)
    }

    /// Returns true where the condition holds for at least one lane.
    #[inline(always)]
    pub fn any(&self, holds: impl Fn(T) -> bool) -> bool {
        // No short cut: eight comparisons cost less than one branch that is hard to foresee.
        let mut any = false;
        for lane in 0..N {
            any |= holds(self.0[lane]);
        }
        any
    }
}

impl<const N: usize> Lanes<N> {
    /// In single precision.
    #[inline(always)]
    pub fn single(&self) -> Lanes<N, f32> {
        Lanes(self.0.map(|value| value as f32))
    }
}

impl<const N: usize, T: Copy + Default> Default for Lanes<N, T> {
    #[inline(always)]
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<const N: usize, T> Index<usize> for Lanes<N, T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, lane: usize) -> &T {
        &self.0[lane]
    }
}

impl<const N: usize, T> IndexMut<usize> for Lanes<N, T> {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut T {
        &mut self.0[lane]
    }
}

/// Quantities of several balls, from which those of one can be taken.
pub trait SideBySide {
    /// The quantities of one ball.
    type One;
    /// Those of a lane.
    fn at(&self, lane: usize) -> Self::One;
    /// Replaces those of a lane.
    fn put(&mut self, lane: usize, one: Self::One);
}

impl<const N: usize, T: Copy> SideBySide for Lanes<N, T> {
    type One = T;

    #[inline(always)]
    fn at(&self, lane: usize) -> T {
        self.0[lane]
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: T) {
        self.0[lane] = one;
    }
}

impl<A: SideBySide, B: SideBySide> SideBySide for (A, B) {
    type One = (A::One, B::One);

    #[inline(always)]
    fn at(&self, lane: usize) -> Self::One {
        (self.0.at(lane), self.1.at(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: Self::One) {
        self.0.put(lane, one.0);
        self.1.put(lane, one.1);
    }
}

impl<C: SideBySide, const COUNT: usize> SideBySide for [C; COUNT] {
    type One = [C::One; COUNT];

    #[inline(always)]
    fn at(&self, lane: usize) -> Self::One {
        std::array::from_fn(|i| self[i].at(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: Self::One) {
        for (column, one) in self.iter_mut().zip(one) {
            column.put(lane, one);
        }
    }
}

/// One value copied into every lane, so that shared values have the layout of values per ball. A register takes it from
/// memory together with an operation, where a single number would have to be spread over the balls before.
pub fn alike<S: SideBySide<One: Copy> + Default>(one: S::One) -> S {
    let mut all = S::default();
    for lane in 0..LANES {
        all.put(lane, one);
    }
    all
}

/// Lets a struct `S<T>` stand for one ball as `S<f64>` or `S<f32>` and for several as `S<Lanes>` or `S<Singles>`.
macro_rules! side_by_side {
    ($name:ident { $($field:ident),* $(,)? }) => {
        impl<const N: usize, T: Copy> $crate::numerics::lanes::SideBySide for $name<$crate::numerics::lanes::Lanes<N, T>> {
            type One = $name<T>;

            #[inline(always)]
            fn at(&self, lane: usize) -> Self::One {
                $name { $($field: $crate::numerics::lanes::SideBySide::at(&self.$field, lane)),* }
            }

            #[inline(always)]
            fn put(&mut self, lane: usize, one: Self::One) {
                $($crate::numerics::lanes::SideBySide::put(&mut self.$field, lane, one.$field);)*
            }
        }
    };
}
pub(crate) use side_by_side;

/// The larger of two numbers, neither NaN: one instruction, where `f64::max` looks for NaN first.
#[inline(always)]
pub fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The smaller of two numbers, neither NaN.
#[inline(always)]
pub fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// Vector instructions that this processor has: no others can be had.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct InstructionSet(Kind);

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Baseline,
    Avx2,
    Avx512,
}

impl fmt::Debug for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Work that is to be compiled once for each instruction set. All that it does has to be `#[inline(always)]`: a function
/// that is only called keeps the instructions it was compiled for.
pub trait Task {
    type Answer;
    fn run(self) -> Self::Answer;
}

impl InstructionSet {
    /// Instructions that every processor of the architecture has.
    pub const BASELINE: Self = Self(Kind::Baseline);

    /// Those that this processor has, the best one last.
    pub fn available() -> impl Iterator<Item = Self> {
        [Kind::Baseline, Kind::Avx2, Kind::Avx512].into_iter().filter(|kind| kind.is_here()).map(Self)
    }

    /// The best one that this processor has.
    pub fn best() -> Self {
        Self::available().last().unwrap_or(Self::BASELINE)
    }

    /// Does the work with these instructions.
    pub fn run<T: Task>(self, task: T) -> T::Answer {
        // Fuzzing builds the formulas once: the sets have the same bits.
        #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
        {
            let run: unsafe fn(T) -> T::Answer = match self.0 {
                Kind::Avx512 => avx512,
                Kind::Avx2 => avx2,
                Kind::Baseline => baseline,
            };
            // Sound, for the processor has these instructions: `available` lets no others out.
            unsafe { run(task) }
        }
        #[cfg(any(not(target_arch = "x86_64"), fuzzing))]
        task.run()
    }
}

impl Kind {
    fn is_here(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }
}

#[cfg(all(target_arch = "x86_64", not(fuzzing)))]
fn baseline<T: Task>(task: T) -> T::Answer {
    task.run()
}

#[cfg(all(target_arch = "x86_64", not(fuzzing)))]
#[target_feature(enable = "avx2")]
fn avx2<T: Task>(task: T) -> T::Answer {
    task.run()
}

#[cfg(all(target_arch = "x86_64", not(fuzzing)))]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512<T: Task>(task: T) -> T::Answer {
    task.run()
}
