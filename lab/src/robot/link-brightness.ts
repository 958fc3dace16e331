// Brightness of links: each uses copies of its materials, tinted by its brightness.
import { Color, type Group, type Material, Mesh } from 'three';

/** A shape with variable brightness, its own material, and the colours of that. */
interface Lamp {
  shape: Mesh;
  plain: Material | Material[];
  lit: { material: Tinted; color: Color }[];
}

interface Tinted extends Material {
  color: Color;
  emissive: Color;
}

export class LinkBrightness {
  private lamps: Lamp[][] | undefined;

  /** Brightness from 0 to 1 for each link; undefined restores the materials. */
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

  /** Restores the materials. */
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
