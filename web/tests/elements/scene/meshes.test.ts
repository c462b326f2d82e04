/** Meshes of a robot: each fetched once, from the hub alone, and no more of them than a page can hold. */

import { describe, expect, it } from "vitest";
import { Mesh } from "three";
import { MeshStore } from "../../../src/elements/scene/meshes.js";
import { MissingMeshes } from "../../../src/elements/scene/missing-meshes.js";

const TRIANGLE = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n";

function storeOver(answer: (url: string) => Response): { readonly store: MeshStore; readonly asked: string[] } {
  const asked: string[] = [];
  const store = new MeshStore("yard", undefined, (url) => {
    asked.push(url as string);
    return Promise.resolve(answer(url as string));
  });
  return { store, asked };
}

describe("a robot's meshes", () => {
  it("are fetched once each, however many links have them, and each link has a copy of its own", async () => {
    const { store, asked } = storeOver(() => new Response(TRIANGLE));
    const [first, second] = await Promise.all([store.load("package://arm/a.stl"), store.load("package://arm/a.stl")]);
    expect(asked).toEqual(["/api/sites/yard/assets?uri=package%3A%2F%2Farm%2Fa.stl"]);
    expect(first).toBeInstanceOf(Mesh);
    expect(second).not.toBe(first);
    expect(Reflect.get(second, "geometry")).toBe(Reflect.get(first, "geometry"));
  });

  it("come from no other address than the hub's", async () => {
    const { store, asked } = storeOver(() => new Response(TRIANGLE));
    for (const uri of ["https://elsewhere.example/a.stl", "file://elsewhere/a.stl", "//elsewhere.example/a.stl"]) await expect(store.load(uri)).rejects.toThrow("only meshes of packages");
    expect(asked).toEqual([]);
  });

  it("are no more than 500 files", async () => {
    const { store, asked } = storeOver(() => new Response(TRIANGLE));
    await Promise.all(Array.from({ length: 500 }, (_, at) => store.load(`package://arm/${String(at)}.stl`)));
    await expect(store.load("package://arm/one-more.stl")).rejects.toThrow("more than 500 meshes");
    expect(asked).toHaveLength(500);
  });

  it("are no more than 256 MiB together", async () => {
    const large = { ok: true, arrayBuffer: () => Promise.resolve({ byteLength: 200 * 1024 * 1024 }) } as unknown as Response;
    const { store } = storeOver(() => large);
    await expect(store.load("package://arm/a.xyz")).rejects.toThrow("are not read");
    await expect(store.load("package://arm/b.xyz")).rejects.toThrow("more than 256 MiB of meshes");
  });

  it("that are named by their place on the robot are asked of the hub, too, without ways up", async () => {
    const { store, asked } = storeOver(() => new Response(TRIANGLE));
    await store.load("file:///opt/robot/meshes/../a.stl");
    expect(asked).toEqual(["/api/sites/yard/assets?uri=file%3A%2F%2F%2Fopt%2Frobot%2Fa.stl"]);
  });

  it("that cannot be had are said with the hub's reason, and asked for again when the robot is drawn anew", async () => {
    const why = JSON.stringify({ code: "unknown", message: "it is not there" });
    const { store, asked } = storeOver(() => new Response(why, { status: 404 }));
    await expect(store.load("package://arm/a.stl")).rejects.toThrow("package://arm/a.stl: it is not there");
    await expect(store.load("package://arm/a.stl")).rejects.toThrow("it is not there");
    expect(asked).toHaveLength(2);
  });
});

describe("meshes that are missing", () => {
  it("are said once each, and in one sentence", () => {
    const said: string[] = [];
    const missing = new MissingMeshes((why) => said.push(why));
    for (const sentence of ["a.stl: it is not there", "a.stl: it is not there", "b.stl: too large"]) missing.add(sentence);
    expect(said).toEqual(["a.stl: it is not there", "2 meshes of the robot are missing. The first: a.stl: it is not there"]);
  });
});
