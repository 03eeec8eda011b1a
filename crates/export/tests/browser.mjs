// Shows GLB files with three.js in headless Chromium.
// Arguments: the folder the packages are installed in, the browser, a folder for pictures or -, then
// the files. Prints one JSON row a file.

import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { createRequire } from 'node:module';

const [folder, browserPath, pictures, ...files] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(folder), 'package.json'));
const puppeteer = require('puppeteer-core');

const PIXELS = 256;
const PAGE = `<!doctype html><link rel="icon" href="data:,">
<script type="importmap">{"imports": {
  "three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(${PIXELS}, ${PIXELS});
document.body.append(renderer.domElement);
const background = new THREE.Color(0xff00ff);

function pixels(scene, camera) {
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const data = new Uint8Array(4 * ${PIXELS} * ${PIXELS});
  gl.readPixels(0, 0, ${PIXELS}, ${PIXELS}, gl.RGBA, gl.UNSIGNED_BYTE, data);
  let shown = 0, top = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] !== 255 || data[i + 1] !== 0 || data[i + 2] !== 255) {
      shown++;
      top = Math.max(top, Math.floor(i / 4 / ${PIXELS}));
    }
  }
  return { shown, top };
}

window.show = async (url) => {
  const file = await new GLTFLoader().loadAsync(url);
  const scene = new THREE.Scene();
  scene.background = background;
  scene.add(file.scene, new THREE.HemisphereLight(0xffffff, 0x888888, 3));
  const box = new THREE.Box3().setFromObject(file.scene);
  const centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
  const half = 0.55 * Math.max(size.x, size.y, size.z);
  const camera = new THREE.OrthographicCamera(-half, half, half, -half, 0, 8 * half);
  camera.position.set(centre.x, centre.y, centre.z + 4 * half);
  const maps = new Set();
  let triangles = 0;
  file.scene.traverse((one) => {
    if (!one.isMesh) return;
    triangles += (one.geometry.index.count / 3) * (one.isInstancedMesh ? one.count : 1);
    for (const map of ['map', 'normalMap', 'roughnessMap']) {
      if (one.material[map]?.image) maps.add(one.material[map].uuid);
    }
  });
  const row = { triangles, maps: maps.size, animations: file.animations.length, frames: [] };
  if (file.animations.length) {
    const mixer = new THREE.AnimationMixer(file.scene);
    const action = mixer.clipAction(file.animations[0]);
    action.setLoop(THREE.LoopOnce);
    action.clampWhenFinished = true;
    action.play();
    file.scene.traverse((one) => (one.frustumCulled = false));
    for (const share of [0, 0.5, 1]) {
      mixer.setTime(share * file.animations[0].duration);
      row.frames.push(pixels(scene, camera));
    }
  } else {
    row.frames.push(pixels(scene, camera));
  }
  // three.js shows the finest level of detail; the coarser ones are there to be asked for.
  for (const node of file.scene.children) {
    const levels = node.userData.gltfExtensions?.MSFT_lod;
    if (!levels) continue;
    row.levels = [];
    for (const id of levels.ids) {
      const level = new THREE.Scene();
      level.background = background;
      level.add(await file.parser.getDependency('node', id));
      level.add(new THREE.HemisphereLight(0xffffff, 0x888888, 3));
      row.levels.push(pixels(level, camera));
    }
  }
  return row;
};
window.ready = true;
</script>`;

const kinds = { '.js': 'text/javascript', '.glb': 'model/gltf-binary' };
const server = http.createServer((request, response) => {
  const url = decodeURIComponent(request.url);
  if (url === '/') {
    response.writeHead(200, { 'content-type': 'text/html' }).end(PAGE);
    return;
  }
  const number = /^\/file\/(\d+)\.glb$/.exec(url);
  const place = number ? files[number[1]] : path.join(folder, path.normalize(url));
  response.writeHead(200, { 'content-type': kinds[path.extname(place)] ?? 'text/plain' });
  fs.createReadStream(place).on('error', () => response.destroy()).pipe(response);
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

const browser = await puppeteer.launch({
  executablePath: browserPath,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
  for (const [i, file] of files.entries()) {
    const page = await browser.newPage();
    const errors = [];
    page.on('console', (message) => {
      if (message.type() === 'error') errors.push(message.text());
    });
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction('window.ready', { timeout: 30000 });
    const row = await page.evaluate((url) => window.show(url), `/file/${i}.glb`);
    if (pictures !== '-') {
      const canvas = await page.$('canvas');
      await canvas.screenshot({ path: path.join(pictures, `${path.basename(file)}.three.png`) });
    }
    console.log(JSON.stringify({ file, ...row, errors }));
    await page.close();
  }
} finally {
  await browser.close();
  server.close();
}
