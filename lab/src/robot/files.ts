// Sorts the user's files into robots and meshes.
import { MeshFiles } from './mesh-files.ts';

export interface Given {
  /** Robot files by path. */
  robots: Map<string, string>;
  meshes: MeshFiles;
}

/** Size limit of robot descriptions. */
const LARGEST = 8_000_000;

/** Files by path with archives extracted. The outermost element of a file tells whether it is a robot. */
export async function sorted(files: ReadonlyMap<string, Blob>): Promise<Given> {
  const all = new Map<string, Blob>();
  for (const [path, file] of files) {
    if (!/\.zip$/i.test(path)) {
      all.set(path, file);
      continue;
    }
    const { unzipSync } = await import('three/addons/libs/fflate.module.js');
    const inside = unzipSync(new Uint8Array(await file.arrayBuffer()));
    for (const [name, bytes] of Object.entries(inside)) all.set(`${path}/${name}`, new Blob([new Uint8Array(bytes)]));
  }
  const robots = new Map<string, string>();
  for (const [path, file] of all) {
    if (!/\.(urdf|xml|mjcf|sdf|scene)$/i.test(path) || file.size > LARGEST) continue;
    const text = await file.text();
    if (/<(robot|mujoco|sdf|scene)[\s>]/.test(text) || all.size === 1) robots.set(path, text);
  }
  const depth = (path: string): number => path.split('/').length;
  // A scene names the other robots.
  const isScene = (path: string): number => Number(/<scene[\s>]/.test(robots.get(path) ?? ''));
  const order = [...robots].sort(([a], [b]) => isScene(b) - isScene(a) || depth(a) - depth(b) || a.localeCompare(b));
  return { robots: new Map(order), meshes: new MeshFiles(all) };
}
