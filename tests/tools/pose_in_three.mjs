// Load a .glb with three.js, pose it, and print where its vertices are.
// The argument is a JSON request: {path, shapes: {name: weight}, motions: [of each joint, row by row], clip, time}.
import { readFile } from "node:fs/promises";

globalThis.self = globalThis; // the loader asks a browser's global object for image decoders
const { AnimationMixer, Matrix4, Vector3 } = await import("three");
const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");
const { MeshoptDecoder } = await import("three/examples/jsm/libs/meshopt_decoder.module.js");

const request = JSON.parse(await readFile(process.argv[2], "utf8"));
const content = await readFile(request.path);
const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
const buffer = content.buffer.slice(content.byteOffset, content.byteOffset + content.byteLength);
const gltf = await loader.parseAsync(buffer, "");
const scene = gltf.scene;

const meshes = [];
scene.traverse((node) => node.isMesh && meshes.push(node));
if (request.clip !== undefined) {
  const mixer = new AnimationMixer(scene);
  mixer.clipAction(gltf.animations.find((clip) => clip.name === request.clip)).play();
  mixer.setTime(request.time);
}
for (const mesh of meshes)
  for (const [name, weight] of Object.entries(request.shapes ?? {}))
    if (name in (mesh.morphTargetDictionary ?? {})) mesh.morphTargetInfluences[mesh.morphTargetDictionary[name]] = weight;
scene.updateMatrixWorld(true);
const rest = new Map();
scene.traverse((node) => rest.set(node, node.matrixWorld.clone()));
const bones = meshes.find((mesh) => mesh.isSkinnedMesh)?.skeleton.bones ?? [];
(request.motions ?? []).forEach((motion, i) => { // parents come first
  const node = bones[i];
  const wanted = new Matrix4().set(...motion.flat()).multiply(rest.get(node));
  node.parent.updateWorldMatrix(true, false);
  node.parent.matrixWorld.clone().invert().multiply(wanted).decompose(node.position, node.quaternion, node.scale);
  node.updateMatrixWorld(true);
});
scene.updateMatrixWorld(true);

const point = new Vector3();
console.log(JSON.stringify({
  animations: gltf.animations.map((clip) => clip.name),
  anatomy: Object.keys(gltf.userData.mien?.anatomy ?? {}),
  meshes: meshes.map((mesh) => ({
    name: mesh.name,
    skinned: mesh.isSkinnedMesh === true,
    shapes: Object.keys(mesh.morphTargetDictionary ?? {}),
    joints: mesh.skeleton?.bones.map((bone) => bone.name) ?? [],
    vertices: Array.from({ length: mesh.geometry.attributes.position.count }, (_, i) =>
      mesh.getVertexPosition(i, point).applyMatrix4(mesh.matrixWorld).toArray()),
  })),
}));
