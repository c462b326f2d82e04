/** This page's side of the service worker: it is registered once the page has time, and says when the pages are new. */

/** The one worker of this origin: shell and push messages. While developing there is no shell to keep. */
export const WORKER_PATH = import.meta.env.PROD ? "/worker.js" : "/push.js";

/** After the page has loaded (ms): what it shows first comes first. */
const LATER_MS = 3000;

/** What is needed of `navigator.serviceWorker`. */
export type WorkerContainer = Pick<ServiceWorkerContainer, "controller" | "register" | "addEventListener" | "removeEventListener">;

/**
 * Registers the worker, and calls `onNew` when another version's takes over: what this page runs
 * is of the one before.
 *
 * @param workers - undefined where the browser has none: over http, and without storage
 * @returns the way to ask whether there is a new version
 */
export function registerWorker(workers: WorkerContainer | undefined, onNew: () => void, later = (run: () => void) => setTimeout(run, LATER_MS)): () => void {
  if (workers === undefined || !import.meta.env.PROD) return () => undefined;
  // The first worker of all takes over a page of its own version.
  let controlled = workers.controller !== null;
  workers.addEventListener("controllerchange", () => {
    if (controlled) onNew();
    controlled = true;
  });
  let registration: ServiceWorkerRegistration | undefined;
  later(() => {
    // A certificate that the browser was told to trust by hand is not good enough for a worker.
    workers.register(WORKER_PATH, { updateViaCache: "none" }).then(
      (made) => {
        registration = made;
      },
      () => undefined,
    );
  });
  return () => {
    void registration?.update().catch(() => undefined);
  };
}
