// Links that glow: each in clones of what its shapes are made of, tinted by how bright it is.
import { Color, type Group, type Material, Mesh } from 'three';

/** A shape that glows, what it is made of otherwise, and the colours of that. */
interface Lamp {
  shape: Mesh;
  plain: Material | Material[];
  lit: { material: Tinted; color: Color }[];
}

interface Tinted extends Material {
  color: Color;
  emissive: Color;
}

export class Lamps {
  private lamps: Lamp[][] | undefined;

  /** Brightness 0 to 1, link by link; undefined puts them out. */
  paint(links: readonly Group[], brightness: Float64Array | undefined, tone: Color): void {
    if (brightness === undefined) {
      this.out();
      return;
    }
    this.lamps ??= links.map(dress);
    this.lamps.forEach((shapes, link) => {
      const share = brightness[link] ?? 0;
      for (const { material, color } of shapes.flatMap(({ lit }) => lit)) {
        material.color.lerpColors(color, tone, 0.85 * share);
        material.emissive.copy(tone).multiplyScalar(0.45 * share);
      }
    });
  }

  /** As they were. */
  out(): void {
    for (const { shape, plain, lit } of this.lamps?.flat() ?? []) {
      shape.material = plain;
      for (const { material } of lit) material.dispose();
    }
    this.lamps = undefined;
  }
}

function dress(link: Group): Lamp[] {
  const lamps: Lamp[] = [];
  for (const part of link.children) {
    if (part.userData['layer'] !== 'shapes') continue;
    part.traverse((one) => {
      if (!(one instanceof Mesh)) return;
      const shape = one as Mesh;
      const plain = shape.material;
      const clones = [plain].flat().map((material) => material.clone());
      shape.material = Array.isArray(plain) ? clones : clones[0]!;
      const lit = clones.filter(isTinted).map((material) => ({ material, color: material.color.clone() }));
      lamps.push({ shape, plain, lit });
    });
  }
  return lamps;
}

function isTinted(material: Material): material is Tinted {
  return 'color' in material && 'emissive' in material;
}
