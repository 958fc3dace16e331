// The scene of a robot: a camera, soft light, and a ground with shadows.
import {
  CircleGeometry, Color, DirectionalLight, Fog, GridHelper, HemisphereLight, Mesh, PCFShadowMap, PerspectiveCamera, Scene,
  ShadowMaterial, Sphere, Vector3, WebGLRenderer,
} from 'three';

import { colour, onTheme } from '../drawing/colours.ts';

/** The camera's vertical field of view [degrees]. */
const FIELD = 32;

/** Whether there is no graphics card. Smooth edges and shadows, half of the work, are then left out. */
function drawsByProcessor(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (gl === null) return false;
  // Chromium names the renderer by an extension that Firefox calls deprecated.
  const short = String(gl.getParameter(gl.RENDERER));
  const long = short.startsWith('WebKit') ? gl.getExtension('WEBGL_debug_renderer_info') : null;
  const renderer = long === null ? short : String(gl.getParameter(long.UNMASKED_RENDERER_WEBGL));
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
}

export class Scenery {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FIELD, 1, 0.01, 100);
  readonly renderer: WebGLRenderer;
  /** The camera's target, direction and distance. */
  readonly target = new Vector3();
  azimuth = -0.7;
  elevation = 0.32;
  distance = 3;
  /** Whether the user chose the distance. */
  chosen = false;
  private readonly sun = new DirectionalLight(0xffffff, 2.3);
  private readonly ground: Mesh<CircleGeometry, ShadowMaterial>;
  private readonly fog = new Fog(0xffffff, 1, 2);
  private grid: GridHelper | undefined;
  private reach = 1;

  /** Throws if the browser has no WebGL. */
  constructor(private readonly onChange: () => void) {
    const simple = drawsByProcessor();
    this.renderer = new WebGLRenderer({ antialias: !simple, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = !simple;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.camera.up.set(0, 0, 1);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 5;
    this.sun.shadow.normalBias = 0.02;
    const fill = new DirectionalLight(0xffffff, 0.7);
    fill.position.set(-2, 3, 1);
    this.ground = new Mesh(new CircleGeometry(1, 64), new ShadowMaterial({ opacity: 0.2 }));
    this.ground.receiveShadow = true;
    this.scene.fog = this.fog;
    this.scene.add(new HemisphereLight(0xffffff, 0xb9b2a4, 1.5), this.sun, this.sun.target, fill, this.ground);
    const dress = (): void => {
      this.fog.color.set(colour('panel'));
      this.lines();
      this.onChange();
    };
    onTheme(dress);
    this.fog.color.set(colour('panel'));
  }

  /** Sets light, ground and far plane for an object of this extent around the target, standing at this
   * height. */
  prepare(reach: number, floor: number): void {
    this.reach = reach;
    this.ground.scale.setScalar(12 * reach);
    this.stand(floor);
    const { camera } = this.sun.shadow;
    Object.assign(camera, { left: -2 * reach, right: 2 * reach, top: 2 * reach, bottom: -2 * reach, near: 0.1 * reach, far: 12 * reach });
    camera.updateProjectionMatrix();
    this.lines();
  }

  /** The height of the ground. */
  stand(floor: number): void {
    this.ground.position.z = floor;
  }

  /** Moves the camera so that a ball is in view. */
  fit(ball: Sphere): void {
    this.chosen = false;
    this.target.copy(ball.center);
    const half = (FIELD * Math.PI) / 360;
    const narrow = Math.atan(Math.tan(half) * Math.min(1, this.camera.aspect));
    this.distance = (1.08 * Math.max(ball.radius, 0.02)) / Math.sin(narrow);
  }

  zoom(factor: number): void {
    this.chosen = true;
    this.distance = Math.min(30 * this.reach, Math.max(0.3 * this.reach, this.distance * factor));
  }

  turn(right: number, up: number): void {
    this.azimuth -= right;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + up));
  }

  resize(width: number, height: number): void {
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
  }

  render(): void {
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const away = new Vector3(ce * Math.cos(this.azimuth), ce * Math.sin(this.azimuth), se);
    this.camera.position.copy(this.target).addScaledVector(away, this.distance);
    this.camera.lookAt(this.target);
    this.camera.near = 0.02 * this.distance;
    this.camera.far = this.distance + 40 * this.reach;
    this.camera.updateProjectionMatrix();
    [this.fog.near, this.fog.far] = [this.distance + this.reach, this.distance + 7 * this.reach];
    this.sun.target.position.copy(this.target);
    this.sun.position.copy(this.target).add(new Vector3(2.2, -1.6, 4).multiplyScalar(this.reach));
    // From below, the ground is hidden.
    this.ground.visible = this.elevation > 0;
    this.ground.position.x = this.target.x;
    this.ground.position.y = this.target.y;
    if (this.grid !== undefined) {
      const cell = this.cell();
      this.grid.position.set(Math.round(this.target.x / cell) * cell, Math.round(this.target.y / cell) * cell, this.ground.position.z);
    }
    this.renderer.render(this.scene, this.camera);
  }

  private cell(): number {
    return 10 ** Math.ceil(Math.log10(this.reach / 2)) / 2;
  }

  private lines(): void {
    this.grid?.dispose();
    if (this.grid !== undefined) this.scene.remove(this.grid);
    const line = new Color(colour('line'));
    const count = 2 * Math.ceil((8 * this.reach) / this.cell());
    this.grid = new GridHelper(count * this.cell(), count, line, line);
    this.grid.rotation.x = Math.PI / 2;
    this.scene.add(this.grid);
  }
}
