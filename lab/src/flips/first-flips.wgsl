// The loop around the generated step of the arm: the start, and the time when a rod first points straight up.
//
// Angles of the rods from the hanging position: q1 + pi/2, and q2 in addition.

struct Arm {
    // The factors k1 and k2 in the potential energy -k1 cos(t1) - k2 cos(t2); the step [s].
    k1: f32,
    k2: f32,
    h: f32,
}

@group(0) @binding(0) var<storage, read_write> q: array<vec2<f32>>;
@group(0) @binding(1) var<storage, read_write> v: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> q_next: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> v_next: array<vec2<f32>>;
// The time of the first flip, -1 before one, -2 if the energy excludes one; and the number of steps.
@group(0) @binding(4) var<storage, read_write> outcome: array<vec2<f32>>;
@group(0) @binding(5) var<uniform> arm: Arm;

const PI = 3.14159265358979;

// The angle modulo 2 pi, from -pi to pi.
fn wrapped(angle: f32) -> f32 {
    return angle - 2.0 * PI * round(angle / (2.0 * PI));
}

@compute @workgroup_size(64)
fn begin(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= arrayLength(&q)) {
        return;
    }
    let first = wrapped(q[i].x + PI / 2.0);
    let rods = vec2<f32>(first, wrapped(first + q[i].y));
    q[i] = vec2<f32>(rods.x - PI / 2.0, rods.y - rods.x);
    let energy = -arm.k1 * cos(rods.x) - arm.k2 * cos(rods.y);
    outcome[i] = vec2<f32>(select(-1.0, -2.0, energy < -abs(arm.k1 - arm.k2)), 0.0);
}

@compute @workgroup_size(64)
fn look(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= arrayLength(&q)) {
        return;
    }
    if (outcome[i].x == -1.0) {
        let steps = outcome[i].y + 1.0;
        let first = q_next[i].x + PI / 2.0;
        let up = max(abs(first), abs(first + q_next[i].y)) >= PI;
        outcome[i] = vec2<f32>(select(-1.0, steps * arm.h, up), steps);
    }
    q[i] = q_next[i];
    v[i] = v_next[i];
}
