import type { ReactiveController, ReactiveControllerHost } from "lit";
import { expect, test } from "vitest";
import { LoadController } from "../../src/controllers/load.js";
import { comeback } from "../../src/wire/backoff.js";

/** An element that draws at once. */
class Host implements ReactiveControllerHost {
  readonly updateComplete = Promise.resolve(true);
  controllers: ReactiveController[] = [];
  draw: () => void = () => undefined;

  addController(controller: ReactiveController): void {
    this.controllers.push(controller);
  }
  removeController(): void {
    this.controllers = [];
  }
  requestUpdate(): void {
    this.draw();
  }
}

test("what failed is asked again when the hub is there again, and what stands is not", async () => {
  const host = new Host();
  const load = new LoadController<string>(host);
  const answers = [Promise.reject(new Error("no hub")), Promise.resolve("here")];
  let asked = 0;
  host.draw = () => {
    load.load("question", () => answers[asked++] ?? Promise.reject(new Error("asked too often")));
  };
  for (const controller of host.controllers) controller.hostConnected?.();
  host.draw();
  await expect.poll(() => load.result.state).toBe("failed");
  comeback.announce();
  await expect.poll(() => load.value).toBe("here");
  comeback.announce();
  expect([asked, load.result.state]).toEqual([2, "ready"]);
  for (const controller of host.controllers) controller.hostDisconnected?.();
});
