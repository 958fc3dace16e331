// Pointers on the picture of a robot: on a link they hold it, elsewhere they turn the view.
import { type Object3D, Plane, Raycaster, Vector2, Vector3 } from 'three';

import type { Scenery } from './scenery.ts';
import type { Hand } from './stage.ts';

export interface Touched {
  /** The objects that a pointer can hit. */
  solids: () => Object3D[];
  isMovable: (link: number) => boolean;
  /** The position of the hand in the world. */
  target: Vector3;
  hand: Hand;
  draw: () => void;
  render: () => void;
}

export function pointers(element: HTMLElement, scenery: Scenery, touchedBy: Touched): void {
  const { solids, isMovable, target, hand, draw, render } = touchedBy;
  const { camera, renderer } = scenery;

  // The hand moves in the plane through the held point that is parallel to the picture.
  const raycaster = new Raycaster();
  const plane = new Plane();
  const aim = (event: { clientX: number; clientY: number }): void => {
    const box = renderer.domElement.getBoundingClientRect();
    const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    raycaster.setFromCamera(new Vector2(2 * x - 1, 1 - 2 * y), camera);
  };
  const touched = (event: { clientX: number; clientY: number }): { link: number; point: Vector3 } | undefined => {
    aim(event);
    for (const { object, point } of raycaster.intersectObjects(solids())) {
      let at: Object3D | null = object;
      while (at !== null && at.userData['link'] === undefined) at = at.parent;
      const link = at?.userData['link'] as number | undefined;
      if (link !== undefined && isMovable(link)) return { link, point };
      return undefined;
    }
    return undefined;
  };
  const fingers = new Map<number, { x: number; y: number }>();
  let holding: number | undefined;
  element.addEventListener('touchstart', (event) => {
    // A finger on the robot holds it; elsewhere it may scroll the page.
    const [finger] = event.touches;
    if (finger !== undefined && (event.touches.length > 1 || touched(finger) !== undefined)) event.preventDefault();
  }, { passive: false });
  element.addEventListener('pointerdown', (event) => {
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    element.setPointerCapture(event.pointerId);
    const found = fingers.size === 1 ? touched(event) : undefined;
    if (found === undefined) return;
    holding = event.pointerId;
    target.copy(found.point);
    plane.setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), found.point);
    element.classList.add('holding');
    hand.grab(found.link, [found.point.x, found.point.y, found.point.z]);
    draw();
  });
  element.addEventListener('pointermove', (event) => {
    const last = fingers.get(event.pointerId);
    if (last === undefined) {
      if (event.pointerType === 'mouse' && event.buttons === 0) element.classList.toggle('over', touched(event) !== undefined);
      return;
    }
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    if (holding === event.pointerId) {
      aim(event);
      if (raycaster.ray.intersectPlane(plane, target) !== null) hand.move([target.x, target.y, target.z]);
    } else if (fingers.size === 2) {
      const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const gap = (x: number, y: number): number => Math.hypot(x - other!.x, y - other!.y);
      scenery.zoom(gap(last.x, last.y) / Math.max(1, gap(event.clientX, event.clientY)));
    } else {
      scenery.turn(dx * 0.008, event.pointerType === 'touch' ? 0 : dy * 0.008);
    }
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    render();
  });
  for (const end of ['pointerup', 'pointercancel'] as const) {
    element.addEventListener(end, (event) => {
      fingers.delete(event.pointerId);
      if (holding !== event.pointerId) return;
      holding = undefined;
      element.classList.remove('holding');
      hand.release();
      draw();
    });
  }
  element.addEventListener('wheel', (event) => {
    // With Ctrl, or by pinching, the wheel zooms; alone it scrolls the page.
    if (!event.ctrlKey) return;
    event.preventDefault();
    scenery.zoom(Math.exp(event.deltaY * 0.004));
    render();
  }, { passive: false });
  element.addEventListener('keydown', (event) => {
    const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    const zoom = { '+': 0.87, '=': 0.87, '-': 1.15 }[event.key];
    if (turn === undefined && zoom === undefined) return;
    event.preventDefault();
    if (turn !== undefined) scenery.turn(turn[0]!, turn[1]!);
    if (zoom !== undefined) scenery.zoom(zoom);
    render();
  });
}
