//! A plain allocator: f = P T' (T P P T')^-1 tau, each thrust cut at its limit. Put your own in its place.
//!
//!     cargo build --release && cp target/release/libmy_allocator.so my_allocator.so
//!
//! The structs are those of thrustbench_allocator.h, version 1, which says what each member means.

use std::os::raw::{c_char, c_int, c_void};
use std::ptr::null;
use std::slice::from_raw_parts;

#[repr(C)]
pub struct Vehicle {
    size: usize,
    k: c_int,
    n: c_int,
    t: *const f64,
    h: *const f64,
    readiness: *const f64,
    f_min: *const f64,
    f_max: *const f64,
    level: *const c_int,
    dof: *const *const c_char,
    frame: *const c_char,
    name: *const c_char,
}

#[repr(C)]
pub struct Input {
    size: usize,
    tau: *const f64,
    f_min: *const f64,
    f_max: *const f64,
    f_previous: *const f64,
    f_desired: *const f64,
    cap: *const f64,
    volts: *const f64,
}

#[repr(C)]
pub struct Output {
    size: usize,
    f: *mut f64,
    share: *mut f64,
    residual: *mut f64,
}

#[repr(C)]
pub struct Promise {
    size: usize,
    formulation: *const c_char,
    limited: c_int,
    tolerance: f64,
    capped: c_int,
}

unsafe impl Sync for Promise {}

static PROMISE: Promise =
    Promise { size: std::mem::size_of::<Promise>(), formulation: null(), limited: 1, tolerance: 1.0, capped: 0 };

const SOLVED: c_int = 0;
const PARTIAL: c_int = 1;
const INFEASIBLE: c_int = 2;

struct Allocator {
    g: Vec<Vec<f64>>,
    f_min: Vec<f64>,
    f_max: Vec<f64>,
}

/// Inverse of a positive definite matrix by Gauss and Jordan; None where it has none.
fn inverse(mut a: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    for p in 0..a.len() {
        let pivot = a[p][p];
        if !(pivot > 1e-9) {
            return None;
        }
        a[p][p] = 1.0;
        let row: Vec<f64> = a[p].iter().map(|x| x / pivot).collect();
        a[p] = row.clone();
        for (i, other) in a.iter_mut().enumerate() {
            if i != p {
                let factor = std::mem::replace(&mut other[p], 0.0);
                other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    Some(a)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn prepare(t: &[f64], readiness: &[f64], f_min: &[f64], f_max: &[f64]) -> Option<Allocator> {
    let n = readiness.len();
    let tp: Vec<Vec<f64>> =
        t.chunks(n).map(|row| row.iter().zip(readiness).map(|(x, p)| x * p).collect()).collect();
    let a = inverse(tp.iter().map(|x| tp.iter().map(|y| dot(x, y)).collect()).collect())?;
    let column = |i: usize| -> Vec<f64> { tp.iter().map(|row| row[i]).collect() };
    let g = (0..n).map(|i| a.iter().map(|row| dot(row, &column(i))).collect()).collect();
    Some(Allocator { g, f_min: f_min.to_vec(), f_max: f_max.to_vec() })
}

impl Allocator {
    fn call(&self, tau: &[f64], f_min: &[f64], f_max: &[f64], f: &mut [f64]) -> c_int {
        let mut status = SOLVED;
        for i in 0..f.len() {
            if f_min[i] > f_max[i] {
                return INFEASIBLE;
            }
            let wanted = dot(&self.g[i], tau);
            f[i] = wanted.max(f_min[i]).min(f_max[i]);
            if f[i] != wanted {
                status = PARTIAL;
            }
        }
        status
    }
}

#[no_mangle]
pub extern "C" fn tba_interface() -> c_int {
    0x100 + std::mem::size_of::<f64>() as c_int
}

#[no_mangle]
pub extern "C" fn tba_promises() -> *const Promise {
    &PROMISE
}

/// # Safety
/// As in thrustbench_allocator.h.
#[no_mangle]
pub unsafe extern "C" fn tba_prepare(vehicle: *const Vehicle, reason: *mut *const c_char) -> *mut c_void {
    let v = &*vehicle;
    let (k, n) = (v.k as usize, v.n as usize);
    let each = |values: *const f64| from_raw_parts(values, n);
    match prepare(from_raw_parts(v.t, k * n), each(v.readiness), each(v.f_min), each(v.f_max)) {
        Some(made) => Box::into_raw(Box::new(made)) as *mut c_void,
        None => {
            *reason = b"its thrusters do not push every axis\0".as_ptr() as *const c_char;
            std::ptr::null_mut()
        }
    }
}

/// # Safety
/// As in thrustbench_allocator.h.
#[no_mangle]
pub unsafe extern "C" fn tba_call(allocator: *mut c_void, input: *const Input, output: *mut Output) -> c_int {
    let (a, input) = (&*(allocator as *const Allocator), &*input);
    let (k, n) = (a.g[0].len(), a.g.len());
    let limits = |given: *const f64, own: *const f64| from_raw_parts(if given.is_null() { own } else { given }, n);
    let f = std::slice::from_raw_parts_mut((*output).f, n);
    let (low, high) = (limits(input.f_min, a.f_min.as_ptr()), limits(input.f_max, a.f_max.as_ptr()));
    a.call(from_raw_parts(input.tau, k), low, high, f)
}
