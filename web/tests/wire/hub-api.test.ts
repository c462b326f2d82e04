import { describe, expect, it } from "vitest";
import { exportPath, HubApi } from "../../src/wire/hub-api.js";

describe("the address of an export", () => {
  it("names each channel, the window, the form, and a width only for what is drawn", () => {
    const query = { channels: ["base/pose.x", "odd/ä&c"], fromUs: 1.4, toUs: 9, format: "parquet", width: 0 } as const;
    const path = exportPath("a b", query);
    expect(path).toBe("/api/sites/a%20b/export?channel=base%2Fpose.x&channel=odd%2F%C3%A4%26c&from_us=1&to_us=9&format=parquet");
    expect(exportPath("agv", { ...query, width: 800 })).toContain("&width=800");
  });
});

describe("a file that the hub cannot give", () => {
  const query = { channels: ["base/speed"], fromUs: 5, toUs: 9_000_000, format: "parquet", width: 300 } as const;

  it("is told in the hub's words, after asking for as little as there is", async () => {
    const asked: string[] = [];
    const api = new HubApi((path) => {
      if (typeof path === "string") asked.push(path);
      return Promise.resolve(Response.json({ code: "not_installed", message: "run: pip install" }, { status: 501 }));
    });
    expect(await api.exportRefusal("agv", query)).toBe("run: pip install");
    expect(asked).toEqual(["/api/sites/agv/export?channel=base%2Fspeed&from_us=5&to_us=6&format=parquet"]);
  });

  it("is nothing where the hub gives it, and a sentence where there is no hub", async () => {
    expect(await new HubApi(() => Promise.resolve(new Response("PAR1"))).exportRefusal("agv", query)).toBe("");
    expect(await new HubApi(() => Promise.reject(new TypeError("offline"))).exportRefusal("agv", query)).toBe("The hub does not answer.");
  });
});

describe("a session that is over", () => {
  const refusedApi = (code: string): { api: HubApi; told: string[] } => {
    const answer = (): Promise<Response> => Promise.resolve(Response.json({ code, message: "no" }, { status: 401 }));
    const api = new HubApi(answer);
    const told: string[] = [];
    api.onSignedOut = () => {
      told.push("over");
      return Promise.resolve(false);
    };
    return { api, told };
  };

  it("is told by the first question that the hub refuses for it", async () => {
    const { api, told } = refusedApi("unauthorized");
    await expect(api.sites()).rejects.toThrow();
    expect(told).toEqual(["over"]);
  });

  it("ends when the person signs in: what a page wanted to know is asked once more, and no deed is done late", async () => {
    const asked: string[] = [];
    let over = true;
    const api = new HubApi((path, init) => {
      asked.push(`${init?.method ?? ""} ${path as string}`);
      return Promise.resolve(over ? Response.json({ code: "unauthorized", message: "no" }, { status: 401 }) : Response.json([]));
    });
    api.onSignedOut = () => {
      over = false;
      return Promise.resolve(true);
    };
    expect(await api.sites()).toEqual([]);
    over = true;
    await expect(api.request("POST", "/api/roles", {})).rejects.toThrow("nothing was done");
    expect(asked).toEqual(["GET /api/sites", "GET /api/sites", "POST /api/roles"]);
  });

  it("is not what a wrong password means, nor the question who is here", async () => {
    const wrong = refusedApi("credentials");
    await expect(wrong.api.request("POST", "/api/me/password", {})).rejects.toThrow();
    const nobody = refusedApi("unauthorized");
    expect(await nobody.api.currentPerson()).toBeNull();
    await expect(nobody.api.login("ada", "wrong")).rejects.toThrow();
    expect([...wrong.told, ...nobody.told]).toEqual([]);
  });
});
