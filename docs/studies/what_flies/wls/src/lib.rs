//! `solve` of wls-alloc behind thrustbench_allocator.h, for six axes and eight thrusters, in single precision.
//!
//! Weights are 1 of each axis over its largest wrench and 1 of each thruster over its range; theta and the bound of
//! the condition are those of its README. Each call starts at the middle of the limits with no set to begin with.

use std::os::raw::{c_char, c_int, c_void};
use std::ptr::null_mut;
use std::slice::{from_raw_parts, from_raw_parts_mut};

use wls_alloc::{setup_a, setup_b, solve, ExitCode, MatA, VecN};

const K: usize = 6;
const N: usize = 8;
const NC: usize = K + N;
const THETA: f32 = 2e-9;
const CONDITION: f32 = 4e5;
const STEPS: usize = 100;

#[repr(C)]
pub struct Vehicle {
    size: usize,
    k: c_int,
    n: c_int,
    t: *const f32,
    h: *const f32,
    readiness: *const f32,
    f_min: *const f32,
    f_max: *const f32,
}

#[repr(C)]
pub struct Input {
    size: usize,
    tau: *const f32,
    f_min: *const f32,
    f_max: *const f32,
}

#[repr(C)]
pub struct Output {
    size: usize,
    f: *mut f32,
}

struct Allocator {
    a: MatA<NC, N>,
    gamma: f32,
    wv: VecN<K>,
    wu: VecN<N>,
    f_min: VecN<N>,
    f_max: VecN<N>,
}

fn prepare(t: &[f32], readiness: &[f32], f_min: &[f32], f_max: &[f32]) -> Allocator {
    let mut g = MatA::<K, N>::zeros();
    let mut wv = VecN::<K>::zeros();
    for j in 0..K {
        for i in 0..N {
            g[(j, i)] = t[j * N + i] * readiness[i];
            wv[j] += g[(j, i)].abs() * f_max[i].max(-f_min[i]);
        }
        wv[j] = 1.0 / wv[j];
    }
    let (f_min, f_max) = (VecN::<N>::from_column_slice(f_min), VecN::<N>::from_column_slice(f_max));
    let mut wu = VecN::<N>::from_element(1.0);
    let (a, gamma) = setup_a::<N, K, NC>(&g, &wv, &mut wu, THETA, CONDITION);
    Allocator { a, gamma, wv, wu, f_min, f_max }
}

fn call(made: &Allocator, tau: &[f32], f_min: &VecN<N>, f_max: &VecN<N>, f: &mut [f32]) -> c_int {
    let b = setup_b::<N, K, NC>(
        &VecN::<K>::from_column_slice(tau),
        &VecN::<N>::zeros(),
        &made.wv,
        &made.wu,
        made.gamma,
    );
    let mut u = (f_min + f_max) * 0.5;
    let mut set = [0i8; N];
    let end = solve::<N, K, NC>(&made.a, &b, f_min, f_max, &mut u, &mut set, STEPS);
    f.copy_from_slice(u.as_slice());
    match end.exit_code {
        ExitCode::Success => 1,
        _ => 3,
    }
}

#[no_mangle]
pub extern "C" fn tba_interface() -> c_int {
    0x100 + std::mem::size_of::<f32>() as c_int
}

/// # Safety
/// As in thrustbench_allocator.h.
#[no_mangle]
pub unsafe extern "C" fn tba_prepare(vehicle: *const Vehicle, reason: *mut *const c_char) -> *mut c_void {
    let v = &*vehicle;
    if (v.k as usize, v.n as usize) != (K, N) {
        *reason = b"it is built for 6 axes and 8 thrusters\0".as_ptr() as *const c_char;
        return null_mut();
    }
    let each = |values: *const f32| from_raw_parts(values, N);
    let made = prepare(from_raw_parts(v.t, K * N), each(v.readiness), each(v.f_min), each(v.f_max));
    Box::into_raw(Box::new(made)) as *mut c_void
}

/// # Safety
/// As in thrustbench_allocator.h.
#[no_mangle]
pub unsafe extern "C" fn tba_call(allocator: *mut c_void, input: *const Input, output: *mut Output) -> c_int {
    let (made, input) = (&*(allocator as *const Allocator), &*input);
    let limits = |given: *const f32, own: &VecN<N>| {
        if given.is_null() { *own } else { VecN::<N>::from_column_slice(from_raw_parts(given, N)) }
    };
    let (low, high) = (limits(input.f_min, &made.f_min), limits(input.f_max, &made.f_max));
    call(made, from_raw_parts(input.tau, K), &low, &high, from_raw_parts_mut((*output).f, N))
}
