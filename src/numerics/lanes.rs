//! One formula for one ball or for several side by side.
//!
//! A formula is written once, for one ball, in `f64`. Where many balls need it, it runs over columns of numbers, [`Lanes`], in a loop
//! whose body has no branch and whose turns know nothing of each other. The compiler then lays the balls side by side in
//! the registers of the processor: two, four or eight at once, by the instruction set that [`InstructionSet::run`] compiles
//! for. Rust never contracts or reorders sums of floats, so that the bits are the same on all of them.
//!
//! What such loops may contain: + − × ÷, √, comparisons that choose a value, own functions made of these (`exponential`,
//! `angle`). A call into the platform's mathematics or an early return would bring the balls back one behind the other; so
//! would constants read through a reference, which a store might change: a copy of them stands before the loop. `cargo
//! bench --bench contact` shows whether balls are side by side.

use std::fmt;
use std::ops::{Index, IndexMut};

/// Balls that stand side by side: one register of AVX-512, two of AVX2, four of SSE2. The same on every machine, so that
/// sums, and with them bits, are the same, too.
pub const LANES: usize = 8;

/// A number of each of `N` balls.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const N: usize = LANES>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    /// The same number for all.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; N])
    }

    /// `N` numbers of a list, from `first` on.
    #[inline(always)]
    pub fn of(list: &[f64], first: usize) -> Self {
        let mut lanes = [0.0; N];
        lanes.copy_from_slice(&list[first..first + N]);
        Self(lanes)
    }

    /// Whether it holds for at least one.
    #[inline(always)]
    pub fn any(&self, holds: impl Fn(f64) -> bool) -> bool {
        // No short cut: eight comparisons cost less than one branch that is hard to foresee.
        let mut any = false;
        for lane in 0..N {
            any |= holds(self.0[lane]);
        }
        any
    }
}

impl<const N: usize> Default for Lanes<N> {
    #[inline(always)]
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> Index<usize> for Lanes<N> {
    type Output = f64;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl<const N: usize> IndexMut<usize> for Lanes<N> {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
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

impl<const N: usize> SideBySide for Lanes<N> {
    type One = f64;

    #[inline(always)]
    fn at(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: f64) {
        self.0[lane] = one;
    }
}

impl<C: SideBySide> SideBySide for (C, C) {
    type One = (C::One, C::One);

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

impl<C: SideBySide> SideBySide for [C; 3] {
    type One = [C::One; 3];

    #[inline(always)]
    fn at(&self, lane: usize) -> Self::One {
        [self[0].at(lane), self[1].at(lane), self[2].at(lane)]
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: Self::One) {
        let [a, b, c] = one;
        self[0].put(lane, a);
        self[1].put(lane, b);
        self[2].put(lane, c);
    }
}

/// Lets a struct `S<T>` stand for one ball as `S<f64>` and for several as `S<Lanes>`.
macro_rules! side_by_side {
    ($name:ident { $($field:ident),* $(,)? }) => {
        impl<const N: usize> $crate::numerics::lanes::SideBySide for $name<$crate::numerics::lanes::Lanes<N>> {
            type One = $name<f64>;

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
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, neither NaN.
#[inline(always)]
pub fn smaller(a: f64, b: f64) -> f64 {
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
    /// What every processor of the architecture has.
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
        #[cfg(target_arch = "x86_64")]
        {
            let run: unsafe fn(T) -> T::Answer = match self.0 {
                Kind::Avx512 => avx512,
                Kind::Avx2 => avx2,
                Kind::Baseline => baseline,
            };
            // Sound, for the processor has these instructions: `available` lets no others out.
            unsafe { run(task) }
        }
        #[cfg(not(target_arch = "x86_64"))]
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

#[cfg(target_arch = "x86_64")]
fn baseline<T: Task>(task: T) -> T::Answer {
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<T: Task>(task: T) -> T::Answer {
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512<T: Task>(task: T) -> T::Answer {
    task.run()
}
