// The files of a robot, such as meshes: found by the end of their path, read by the loaders of three.js.
import { Group, Mesh, type Object3D } from 'three';

export class MeshFiles {
  /** Files by path, from a folder or an archive. */
  constructor(readonly files: ReadonlyMap<string, Blob> = new Map()) {}

  get count(): number {
    return this.files.size;
  }

  /** The mesh that a robot's file names; `undefined` if it is missing or cannot be read. */
  async load(name: string): Promise<Object3D | undefined> {
    const file = this.find(name);
    if (file === undefined) return undefined;
    try {
      return await read(name, file);
    } catch {
      return undefined;
    }
  }

  /** The file whose path shares the longest end with the name. */
  find(name: string): Blob | undefined {
    const asked = parts(name);
    let best: Blob | undefined;
    let most = 0;
    for (const [path, file] of this.files) {
      const found = parts(path);
      let common = 0;
      while (common < Math.min(asked.length, found.length) && asked.at(-1 - common) === found.at(-1 - common)) common += 1;
      if (common > most) [best, most] = [file, common];
    }
    return best;
  }
}

function parts(path: string): string[] {
  return path.toLowerCase().replace(/^[a-z]+:\/\//, '').split(/[\\/]+/).filter((part) => part !== '' && part !== '.' && part !== '..');
}

async function read(name: string, file: Blob): Promise<Object3D | undefined> {
  switch (/\.([a-z0-9]+)$/i.exec(name)?.[1]?.toLowerCase()) {
    case 'stl': {
      const { STLLoader } = await import('three/addons/loaders/STLLoader.js');
      return new Mesh(new STLLoader().parse(await file.arrayBuffer()));
    }
    case 'obj': {
      const { OBJLoader } = await import('three/addons/loaders/OBJLoader.js');
      return new OBJLoader().parse(await file.text());
    }
    case 'dae': {
      const { ColladaLoader } = await import('three/addons/loaders/ColladaLoader.js');
      const scene = new ColladaLoader().parse(await file.text(), '')?.scene;
      if (scene === undefined) return undefined;
      // Robot files use the mesh's own axes, whichever axis its file declares as up.
      scene.position.set(0, 0, 0);
      scene.quaternion.identity();
      return new Group().add(scene);
    }
    default:
      return undefined;
  }
}
