// A robot's file with the files that it includes or takes inertia from.
import type { Robot, Robots } from '../../lib/dynamics/index.ts';
import type { MeshFiles } from './mesh-files.ts';

/** A robot's file and its companions. */
export interface Source {
  /** Name of a bundled robot; empty for the user's. */
  name: string;
  text: string;
  meshes: MeshFiles;
  /** Its path among the files; undefined for a text alone. */
  path?: string | undefined;
}

export async function read(robots: Robots, { text, path, meshes }: Source, floating: boolean): Promise<Robot> {
  return path === undefined ? robots.Robot.load(text, floating, true) : readAmong(robots, meshes.files, path, floating);
}

/** Meshes are passed only if the robot needs them. */
async function readAmong(robots: Robots, files: ReadonlyMap<string, Blob>, path: string, floating: boolean): Promise<Robot> {
  const given = new robots.RobotFiles();
  const add = async (kind: RegExp): Promise<number> => {
    const some = [...files].filter(([name]) => kind.test(name));
    for (const [name, file] of some) given.add(name, new Uint8Array(await file.arrayBuffer()));
    return some.length;
  };
  try {
    await add(/\.(xml|mjcf|urdf|sdf|config|scene)$/i);
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

/** Whether a file depends on other files. */
export const includes = (text: string): boolean => /<(include\s|scene[\s>])/.test(text);
