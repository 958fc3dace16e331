// A robot in three dimensions that the user can pull.
import {
  AmbientLight, Box3, BufferGeometry, Color, Group, Line, LineBasicMaterial, Mesh, Sphere, SphereGeometry, Vector3,
} from 'three';

import { numberFrom } from '../address.ts';
import { colour, onTheme } from '../drawing/colours.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { assemble, type Assembly, points } from './assembly.ts';
import { LinkBrightness } from './link-brightness.ts';
import type { MeshFiles } from './mesh-files.ts';
import { pointers } from './pointers.ts';
import { contactArrows } from './contact-arrows.ts';
import { Scenery } from './scenery.ts';
import { Materials, placed } from './solids.ts';
import { POSE, type Hand, type Layers, type Stage } from './stage.ts';

/** The fraction of the picture that a fitted robot fills. */
const FILL = 0.9;
/** Distance of a link's origin from the centre at which the camera moves back; the link extends beyond it. */
const EDGE = 0.8;
const START = { azimuth: -0.7, elevation: 0.32 };

/** Throws if the browser has no WebGL. Calls back when the robot has received meshes for contact. */
export function solidStage(hand: Hand, onMeshes: () => void): Stage {
  const scenery = new Scenery(() => { dress(); });
  const { scene, camera, renderer } = scenery;
  const element = html('div', {
    class: 'stage', tabindex: 0, role: 'group',
    'aria-label': 'The robot. Drag a link to pull it, the ground or the arrow keys to look from another side, + and − to zoom.',
  }, renderer.domElement);
  renderer.domElement.setAttribute('aria-hidden', 'true');

  let robot: Robot | undefined;
  let links: Group[] = [];
  let movable: boolean[] = [];
  let shown: Layers = { shapes: true, collision: false, inertia: false, forces: true };
  let reach = 1;
  /** Height of the drawn ground if the robot has none. */
  let backdrop = 0;
  /** Height of the robot's ground, if it has contact. */
  let level = 0;
  let began = new Vector3();
  let materials = palette();
  const lamps = new LinkBrightness();
  let brightness: Float64Array | undefined;
  /** Whether the address sets the viewpoint. */
  let restored = false;
  let rebuild: () => Promise<unknown> = () => Promise.resolve();

  const felt = new Mesh(new SphereGeometry(1, 32, 20), materials.named('mass', 0.35));
  felt.matrixAutoUpdate = false;
  const string = new Line(new BufferGeometry(), new LineBasicMaterial({ color: colour('accent') }));
  string.frustumCulled = false;
  const arrows = contactArrows(new Color(colour('accent')));
  scene.add(felt, string, arrows.group, new AmbientLight(0xffffff, 0.25));
  const target = new Vector3();

  /** Colours follow the theme. */
  const dress = (): void => {
    materials.dispose();
    materials = palette();
    string.material.color.set(colour('accent'));
    felt.material = materials.named('mass', 0.35);
    arrows.paint(new Color(colour('accent')));
    void rebuild();
  };
  onTheme(() => { render(); });

  const show = async (next: Robot, files: MeshFiles): Promise<readonly string[]> => {
    robot = next;
    rebuild = () => build(next, files);
    const { absent, hulls } = await build(next, files);
    if (next === robot && hulls.length > 0) {
      for (const hull of hulls) next.giveMesh(hull.shape.number, points(hull));
      onMeshes();
    }
    fit();
    return absent;
  };

  const build = async (of: Robot, files: MeshFiles): Promise<Assembly> => {
    const made = await assemble(of, files, materials);
    // Another robot may have been requested meanwhile.
    if (of !== robot) return made;
    lamps.out();
    for (const link of links) scene.remove(link);
    ({ links, movable, reach } = made);
    scene.add(...links);
    layers(shown);
    draw();
    const ball = extent();
    // A floating robot starts on the ground.
    const ground = made.ground ?? 0;
    level = of.groundHeight;
    backdrop = of.floats ? Math.min(ground, new Box3().setFromObject(tangible()).min.z) : ground;
    scenery.prepare(Math.max(reach, ball.radius), backdrop);
    began = middle();
    draw();
    return made;
  };

  const layers = (next: Layers): void => {
    shown = next;
    for (const link of links) {
      for (const part of link.children) {
        const layer = part.userData['layer'] as keyof Layers;
        part.visible = shown[layer];
        part.traverse((one) => {
          one.castShadow = layer === 'shapes' && part.userData['flat'] !== true;
          one.receiveShadow = layer === 'shapes';
        });
      }
    }
    arrows.group.visible = next.forces;
    element.dataset['parts'] = String(links.flatMap((link) => link.children).filter(({ visible }) => visible).length);
    render();
  };

  /** The links that can move, without the world of a scene. */
  const movers = (): Group[] => links.filter((_, link) => movable[link] === true);
  /** The mean position of the links, which the camera follows. */
  const middle = (): Vector3 => {
    const sum = new Vector3();
    const moving = movers();
    for (const link of moving) sum.add(new Vector3().setFromMatrixPosition(link.matrix));
    return sum.divideScalar(Math.max(1, moving.length));
  };
  /** All solids except unbounded planes. */
  const tangible = (): Group => {
    const all = new Group();
    for (const link of links) {
      for (const part of link.children) {
        if (part.userData['flat'] === true || !(part.visible || part.userData['layer'] === 'inertia')) continue;
        const copy = part.clone();
        copy.matrix.premultiply(link.matrix);
        copy.matrixAutoUpdate = false;
        copy.matrix.decompose(copy.position, copy.quaternion, copy.scale);
        all.add(copy);
      }
    }
    all.updateMatrixWorld(true);
    return all;
  };
  const extent = (): Sphere => {
    const box = new Box3().setFromObject(tangible(), true);
    return box.isEmpty() ? new Sphere(new Vector3(), 0.5) : box.getBoundingSphere(new Sphere());
  };
  const fit = (): void => {
    scenery.fit(extent());
    began = middle();
    render();
    // The bounding ball is larger than the projection.
    for (let again = 0; again < 3; again += 1) {
      scenery.distance *= Math.max(0.4, Math.min(2, spread() / FILL));
      render();
    }
    element.dataset['spread'] = spread().toFixed(4);
  };
  /** The extent of the robot in the picture: 1 is its edge. */
  const spread = (): number => {
    const { min, max } = new Box3().setFromObject(tangible(), true);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) =>
      new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z).project(camera));
    return Math.max(...corners.flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)]));
  };

  const at = new Vector3();
  /** Moves the camera back if the robot leaves the picture, unless the user chose the distance. */
  const keepInSight = (): void => {
    let far = 0;
    for (const link of movers()) {
      at.setFromMatrixPosition(link.matrix).project(camera);
      far = Math.max(far, Math.abs(at.x), Math.abs(at.y));
    }
    if (far > EDGE && !scenery.chosen) scenery.distance *= Math.min(1.03, far / EDGE);
    const outermost = far.toFixed(1);
    if (element.dataset['outermost'] !== outermost) element.dataset['outermost'] = outermost;
  };

  const draw = (): void => {
    if (robot === undefined || links.length === 0) return;
    const poses = robot.poses();
    links.forEach((link, i) => {
      link.matrix.copy(placed(poses, POSE * i));
      link.matrixWorldNeedsUpdate = true;
    });
    lamps.paint(links, brightness, new Color(colour('accent')));
    const held = robot.heldPoint();
    felt.visible = held.length === 3;
    string.visible = felt.visible;
    if (felt.visible) {
      const at = new Vector3(...held);
      string.geometry.setFromPoints([at, target]);
      const mass = robot.feltMass();
      const heaviest = Math.max(1e-6, ...Array.from(mass?.masses ?? [], (m) => (Number.isFinite(m) && m < 1e4 ? m : 0)));
      const semi = (m: number): number => 0.16 * reach * Math.sqrt(Math.min(1, m / heaviest));
      if (mass !== undefined) {
        felt.matrix.copy(placed([...mass.axes, ...held])).scale(new Vector3(...Array.from(mass.masses, semi)));
        felt.matrixWorldNeedsUpdate = true;
      }
    }
    scenery.stand(robot.grounded ? level : backdrop);
    const contacts = robot.contactForces();
    element.dataset['contacts'] = String(contacts.length / 6);
    if (arrows.group.visible) arrows.draw(contacts, 9.81 * robot.totalMass, reach);
    keepInSight();
    // The camera follows a falling robot.
    if (robot.floats) {
      const now = middle();
      scenery.target.add(now).sub(began);
      began = now;
    }
    render();
  };
  const render = (): void => {
    scenery.render();
    element.dataset['frames'] = String(renderer.info.render.frame);
    element.dataset['triangles'] = String(renderer.info.render.triangles);
  };

  pointers(element, scenery, {
    solids: () => links.flatMap((link) => link.children.filter(({ visible }) => visible)),
    isMovable: (link) => movable[link] === true,
    target, hand, draw, render,
  });
  new ResizeObserver((entries) => {
    const { width = 0, height = 0 } = entries.at(-1)?.contentRect ?? {};
    if (width === 0) return;
    const first = renderer.domElement.dataset['sized'] === undefined;
    renderer.domElement.dataset['sized'] = 'true';
    scenery.resize(width, height);
    if (first && !restored) fit();
    else render();
  }).observe(element);

  return {
    element, show, draw, fit, layers,
    glow(next) {
      brightness = next;
      element.dataset['brightest'] = String(Math.max(0, ...next ?? []));
    },
    look(azimuth, elevation) {
      [scenery.azimuth, scenery.elevation] = [azimuth, elevation];
      fit();
    },
    shared: () => {
      const { azimuth, elevation, distance, target: { x, y, z } } = scenery;
      return { azimuth, elevation, distance, 'at-x': x, 'at-y': y, 'at-z': z };
    },
    restore(values) {
      restored = values.has('distance');
      scenery.azimuth = numberFrom(values, 'azimuth', START.azimuth);
      scenery.elevation = Math.max(-1.5, Math.min(1.5, numberFrom(values, 'elevation', START.elevation)));
      const { x, y, z } = scenery.target;
      scenery.target.set(numberFrom(values, 'at-x', x), numberFrom(values, 'at-y', y), numberFrom(values, 'at-z', z));
      scenery.zoom(Math.max(1e-3, numberFrom(values, 'distance', scenery.distance)) / scenery.distance);
      render();
    },
  };
}

function palette(): Materials {
  const tone = (name: Parameters<typeof colour>[0], towards: Parameters<typeof colour>[0], share: number): Color =>
    new Color(colour(name)).lerp(new Color(colour(towards)), share);
  return new Materials({
    part: tone('second', 'panel', 0.35), pin: tone('ink', 'panel', 0.22), mass: tone('accent', 'panel', 0.1),
    collision: tone('accent', 'panel', 0.3),
  });
}
