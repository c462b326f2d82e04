/** Meshes of robots from the hub: each fetched once for a page, bounded; the browser keeps them by their content. */

import { LoadingManager, Mesh, MeshLambertMaterial, type Object3D } from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { refusalOf } from "../../wire/hub-api.js";

/** Bytes of all meshes of a robot; more is not a robot but an attack on this page's memory. */
const MOST_BYTES = 256 * 1024 * 1024;
const MOST_FILES = 500;

export class MeshStore {
  private readonly loaded = new Map<string, Promise<Object3D>>();
  private bytes = 0;
  private files = 0;

  /** Pictures that meshes are painted with: from where meshes come from. */
  readonly pictures = new LoadingManager();

  /** @param onChange the pictures of a mesh have come, after it */
  constructor(
    private readonly site: string,
    onChange: () => void = () => undefined,
    private readonly fetcher: typeof fetch = fetch.bind(globalThis),
  ) {
    this.pictures.setURLModifier((url) => (isAsset(url) ? assetUrl(site, url) : url));
    this.pictures.onLoad = onChange;
  }

  /** A copy of the mesh that a URI names. Rejects with a sentence for people. */
  async load(uri: string): Promise<Object3D> {
    let mesh = this.loaded.get(uri);
    if (mesh === undefined) {
      mesh = this.fetchMesh(uri);
      this.loaded.set(uri, mesh);
      // What was missing may be there when the robot is drawn anew.
      mesh.catch(() => this.loaded.delete(uri));
    }
    return (await mesh).clone();
  }

  private async fetchMesh(uri: string): Promise<Object3D> {
    // No other origin is ever asked.
    if (!isAsset(uri)) throw new Error(`${uri}: only meshes of packages (package://…) are fetched`);
    if (++this.files > MOST_FILES) throw new Error(`more than ${String(MOST_FILES)} meshes`);
    const answer = await this.fetcher(assetUrl(this.site, uri));
    if (!answer.ok) throw new Error(`${uri}: ${(await refusalOf(answer)).message}`);
    const data = await answer.arrayBuffer();
    this.bytes += data.byteLength;
    if (this.bytes > MOST_BYTES) throw new Error(`more than ${String(MOST_BYTES / 1024 / 1024)} MiB of meshes`);
    return readMesh(uri, data, this.pictures);
  }
}

function assetUrl(site: string, uri: string): string {
  return `/api/sites/${encodeURIComponent(site)}/assets?${new URLSearchParams({ uri: withoutWaysUp(uri) }).toString()}`;
}

/** A file of the robot, which only its hub is asked for. */
function isAsset(uri: string): boolean {
  return uri.startsWith("package://") || uri.startsWith("file:///");
}

/** `package://arm/meshes/../paint/a.png` is `package://arm/paint/a.png`: the hub takes no ways up. */
function withoutWaysUp(uri: string): string {
  const [scheme = "", rest = ""] = uri.split("://", 2);
  const parts: string[] = [];
  for (const part of rest.split("/")) {
    if (part === "..") parts.pop();
    else if (part !== ".") parts.push(part);
  }
  return `${scheme}://${parts.join("/")}`;
}

async function readMesh(uri: string, data: ArrayBuffer, pictures: LoadingManager): Promise<Object3D> {
  const folder = uri.slice(0, uri.lastIndexOf("/") + 1);
  const ending = uri.slice(uri.lastIndexOf(".") + 1).toLowerCase();
  switch (ending) {
    case "stl":
      return new Mesh(new STLLoader().parse(data), new MeshLambertMaterial());
    case "dae": {
      const { ColladaLoader } = await import("three/examples/jsm/loaders/ColladaLoader.js");
      const read = new ColladaLoader(pictures).parse(new TextDecoder().decode(data), folder);
      if (read === null) throw new Error(`${uri}: it is no Collada file`);
      return read.scene;
    }
    case "obj": {
      const { OBJLoader } = await import("three/examples/jsm/loaders/OBJLoader.js");
      return new OBJLoader().parse(new TextDecoder().decode(data));
    }
    case "glb": {
      const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");
      return (await new GLTFLoader(pictures).parseAsync(data, folder)).scene;
    }
    default:
      throw new Error(`${uri}: meshes that end in .${ending} are not read (stl, dae, obj and glb are)`);
  }
}
