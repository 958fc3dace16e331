// The map of flips on a graphics card by WebGPU. The step of the arm is the shader that `dynamics generate`
// writes for robots/two_r.urdf: the library's recursions in single precision.
import step from './arm_rk4_step.wgsl?raw';
import around from './first-flips.wgsl?raw';
import { queue } from './queue.ts';
import type { Done, Job, Setup } from './worker.ts';
import type { Pool } from './workers.ts';

/** Flags of the standard, which the types lack. */
const [COMPUTE, MAP_READ, COPY_SRC, COPY_DST, UNIFORM, STORAGE, READ] = [0x4, 0x1, 0x4, 0x8, 0x40, 0x80, 0x1] as const;
/** Threads in a workgroup, as in the shaders. */
const GROUP = 64;
/** Number of steps submitted at once, limited since the card also draws the page. */
const AT_ONCE = 250;

/** A card for computing; none if the browser has no WebGPU, or only a software adapter. */
export async function graphicsCard(): Promise<GPUDevice | undefined> {
  // Not defined in every browser, despite the types.
  const gpu = (navigator as { gpu?: GPU }).gpu;
  const adapter = await gpu?.requestAdapter({ powerPreference: 'high-performance' }).catch(() => null);
  return !adapter || adapter.info.isFallbackAdapter ? undefined : adapter.requestDevice().catch(() => undefined);
}

/** The pool of one card, for the arm of the generated step. */
export function flipCard(device: GPUDevice, [l1, m1, l2, m2, gravity, h]: Setup['arm']): Pool {
  const layout = (types: readonly GPUBufferBindingType[]): GPUBindGroupLayout => device.createBindGroupLayout({
    entries: types.map((type, binding) => ({ binding, visibility: COMPUTE, buffer: { type } })),
  });
  const pipeline = (code: string, own: GPUBindGroupLayout, entryPoint: string): GPUComputePipeline => device.createComputePipeline({
    layout: device.createPipelineLayout({ bindGroupLayouts: [own] }),
    compute: { module: device.createShaderModule({ code }), entryPoint },
  });
  const ofStep = layout(['read-only-storage', 'read-only-storage', 'read-only-storage', 'read-only-storage', 'storage', 'storage']);
  const ofFlips = layout(['storage', 'storage', 'read-only-storage', 'read-only-storage', 'storage', 'uniform']);
  const [advance, begin, look] = [pipeline(step, ofStep, 'main'), pipeline(around, ofFlips, 'begin'), pipeline(around, ofFlips, 'look')];
  const buffer = (bytes: number, usage: GPUBufferUsageFlags): GPUBuffer => device.createBuffer({ size: bytes, usage });
  const filled = (numbers: Float32Array<ArrayBuffer>, usage: GPUBufferUsageFlags): GPUBuffer => {
    const made = buffer(numbers.byteLength, usage | COPY_DST);
    device.queue.writeBuffer(made, 0, numbers);
    return made;
  };
  // Uniform rods: k₁ = (m₁ l₁/2 + m₂ l₁) a_g, k₂ = m₂ l₂/2 a_g.
  const arm = filled(Float32Array.of((m1 / 2 + m2) * l1 * gravity, (m2 * l2 * gravity) / 2, h, 0), UNIFORM);

  const compute = async ({ starts, duration }: Job): Promise<Done> => {
    const count = starts.length / 2;
    const two = 8 * count;
    const [q, v, tau] = [filled(Float32Array.from(starts), STORAGE), buffer(two, STORAGE), buffer(two, STORAGE)];
    const steps = filled(new Float32Array(count).fill(h), STORAGE);
    const [qNext, vNext, outcome] = [buffer(two, STORAGE), buffer(two, STORAGE), buffer(two, STORAGE | COPY_SRC)];
    const read = buffer(two, COPY_DST | MAP_READ);
    const group = (own: GPUBindGroupLayout, buffers: readonly GPUBuffer[]): GPUBindGroup => device.createBindGroup({
      layout: own, entries: buffers.map((one, binding) => ({ binding, resource: { buffer: one } })),
    });
    const stepGroup = group(ofStep, [q, v, tau, steps, qNext, vNext]);
    const flipGroup = group(ofFlips, [q, v, qNext, vNext, outcome, arm]);
    const groups = Math.ceil(count / GROUP);
    let left = Math.round(duration / h);
    for (let first = true; left > 0; first = false) {
      const encoder = device.createCommandEncoder();
      const pass = encoder.beginComputePass();
      const run = (what: GPUComputePipeline, of: GPUBindGroup): void => {
        pass.setPipeline(what);
        pass.setBindGroup(0, of);
        pass.dispatchWorkgroups(groups);
      };
      if (first) run(begin, flipGroup);
      for (let k = Math.min(left, AT_ONCE); k > 0; k -= 1) {
        run(advance, stepGroup);
        run(look, flipGroup);
      }
      left -= AT_ONCE;
      pass.end();
      if (left <= 0) encoder.copyBufferToBuffer(outcome, 0, read, 0, two);
      device.queue.submit([encoder.finish()]);
    }
    await read.mapAsync(READ);
    const found = new Float32Array(read.getMappedRange().slice(0));
    for (const one of [q, v, tau, steps, qNext, vNext, outcome, read]) one.destroy();
    const column = (k: number): Float32Array<ArrayBuffer> => Float32Array.from({ length: count }, (_, i) => found[2 * i + k]!);
    return { times: column(0), steps: column(1).reduce((sum, taken) => sum + taken, 0) };
  };

  const { run, forget } = queue([compute]);
  return { says: 'single precision, on the graphics card by WebGPU', each: 16_384, flips: run, forget };
}
