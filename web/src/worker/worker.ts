/**
 * The service worker of the pages: they open fast, and where there is no hub it says so.
 *
 * It keeps the built shell (scripts and styles by their hash, and the offline page), nothing else:
 * no data, no picture, nothing that a sign-in is needed for, so that it can never show an old value
 * as a new one. Pages always come from the hub. It carries the push messages, too.
 */

import { CACHE_PREFIX, expiredCaches, handlingOf, isHashed, mayKeep, OFFLINE_PAGE } from "./shell-cache.js";

/** What of `ServiceWorkerGlobalScope` is used; its own types cannot stand beside those of pages. */
interface WorkerScope {
  readonly location: { readonly origin: string };
  readonly clients: { claim(): Promise<void> };
  addEventListener(type: "install" | "activate", listener: (event: LifetimeEvent) => void): void;
  addEventListener(type: "fetch", listener: (event: FileEvent) => void): void;
  skipWaiting(): Promise<void>;
  importScripts(path: string): void;
}

interface LifetimeEvent {
  waitUntil(done: Promise<unknown>): void;
}

interface FileEvent extends LifetimeEvent {
  readonly request: Request;
  respondWith(answer: Promise<Response>): void;
}

const scope = self as unknown as WorkerScope;
/** Filled in when the pages are built; see `vite.config.ts`. */
const FILES: readonly string[] = JSON.parse("__SHELL_FILES__") as string[];
const CACHE = `${CACHE_PREFIX}__SHELL_VERSION__`;
const KEPT: ReadonlySet<string> = new Set(FILES);

scope.importScripts("/push.js");

scope.addEventListener("install", (event) => {
  event.waitUntil(installShell());
});

scope.addEventListener("activate", (event) => {
  event.waitUntil(activateShell());
});

scope.addEventListener("fetch", (event) => {
  const { request } = event;
  switch (handlingOf(request, scope.location.origin, KEPT)) {
    case "page":
      event.respondWith(fetch(request).catch(() => findKept(OFFLINE_PAGE)));
      return;
    case "hashed":
      event.respondWith(fetchHashed(request));
      return;
    case "plain":
      event.respondWith(fetch(request).catch(() => findKept(request.url)));
      return;
    case "hub":
      // Left to the browser, as if there were no worker.
      return;
  }
});

/** All of it or nothing: a worker with half a shell would not be installed. */
async function installShell(): Promise<void> {
  try {
    const cache = await caches.open(CACHE);
    // Without cookies: what is kept is what everybody gets.
    await cache.addAll(FILES.map((path) => new Request(path, { credentials: "omit", cache: isHashed(path) ? "default" : "reload" })));
  } catch (error) {
    await caches.delete(CACHE);
    throw error;
  }
  // Pages come from the hub in any case, so that nobody has to wait for the last old one to be closed.
  await scope.skipWaiting();
}

async function activateShell(): Promise<void> {
  const names = await caches.keys();
  await Promise.all(expiredCaches(names, CACHE).map((name) => caches.delete(name)));
  await scope.clients.claim();
}

async function fetchHashed(request: Request): Promise<Response> {
  const held = await caches.match(request, { ignoreVary: true });
  if (held !== undefined) return held;
  const answer = await fetch(request);
  if (mayKeep(answer)) {
    const cache = await caches.open(CACHE);
    // A full disk is no reason to be without the file.
    await cache.put(request, answer.clone()).catch(() => undefined);
  }
  return answer;
}

async function findKept(path: string): Promise<Response> {
  return (await caches.match(path, { ignoreVary: true })) ?? Response.error();
}
