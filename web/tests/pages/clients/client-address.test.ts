import { describe, expect, test } from "vitest";
import { clientAddress } from "../../../src/pages/clients/client-address.js";

describe("the address of a client protocol", () => {
  const foxglove = { path: "/clients/foxglove/{site}", socket: true };

  test("is a WebSocket of the hub's own origin, encrypted where the page is", () => {
    expect(clientAddress(foxglove, "agv", "https://hub.example:8443")).toBe("wss://hub.example:8443/clients/foxglove/agv?token=TOKEN");
    expect(clientAddress(foxglove, "agv", "http://localhost:8000")).toBe("ws://localhost:8000/clients/foxglove/agv?token=TOKEN");
  });

  test("is an address of the web for a protocol that is no socket", () => {
    expect(clientAddress({ path: "/clients/prometheus/{site}", socket: false }, "a b", "https://hub")).toBe(
      "https://hub/clients/prometheus/a%20b?token=TOKEN",
    );
    expect(clientAddress({ path: "/?site={site}", socket: false }, "agv", "https://hub")).toBe("https://hub/?site=agv&token=TOKEN");
  });
});
