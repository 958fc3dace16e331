// A robot's file with those that lie beside it: what it includes, and meshes that inertia comes from.
import type { Robot, Robots } from '../../lib/dynamics/index.ts';
import type { MeshFiles } from './mesh-files.ts';

/** A robot's file, and what came with it. */
export interface Source {
  /** Of a bundled robot; empty for one that was given. */
  name: string;
  text: string;
  meshes: MeshFiles;
  /** Its place among the files; undefined for a text alone. */
  path?: string | undefined;
}

export async function read(robots: Robots, { text, path, meshes }: Source, floating: boolean): Promise<Robot> {
  return path === undefined ? robots.Robot.load(text, floating, true) : readAmong(robots, meshes.files, path, floating);
}

/** Meshes are handed over only where the robot does not do without. */
async function readAmong(robots: Robots, files: ReadonlyMap<string, Blob>, path: string, floating: boolean): Promise<Robot> {
  const given = new robots.RobotFiles();
  const add = async (kind: RegExp): Promise<number> => {
    const some = [...files].filter(([name]) => kind.test(name));
    for (const [name, file] of some) given.add(name, new Uint8Array(await file.arrayBuffer()));
    return some.length;
  };
  try {
    await add(/\.(xml|mjcf|urdf)$/i);
    try {
      return robots.Robot.loadAmong(given, path, floating, true);
    } catch (error) {
      if ((await add(/\.(stl|obj|msh)$/i)) === 0) throw error;
      return robots.Robot.loadAmong(given, path, floating, true);
    }
  } finally {
    given.free();
  }
}

/** Whether a file says nothing of a robot without others. */
export const includes = (text: string): boolean => /<include\s/.test(text);
