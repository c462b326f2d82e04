/** This browser's side of Web Push: asks the person, and subscribes at the browser's push service. */

import { msg } from "@lit/localize";
import type { PushAsk } from "../generated/api.js";
import { WORKER_PATH } from "../worker/shell-worker.js";

/** Why a browser cannot, in words; empty when it can. */
export function whyNoPush(): string {
  if (!window.isSecureContext) return msg("Browsers take push messages only over https.");
  if (!("serviceWorker" in navigator) || !("PushManager" in window)) {
    return msg("This browser takes no push messages (on an iPhone, add the page to the home screen first).");
  }
  return "";
}

/**
 * Subscribes this browser.
 *
 * @param key the hub's public key (VAPID), base64url
 * @throws Error when the person or the browser says no
 */
export async function subscribePush(key: string): Promise<PushAsk> {
  if ((await Notification.requestPermission()) !== "granted") throw new Error("Messages are not allowed in this browser.");
  const worker = await navigator.serviceWorker.register(WORKER_PATH);
  await navigator.serviceWorker.ready;
  // One of a former key of the hub's stands in the way of the new one.
  await (await worker.pushManager.getSubscription())?.unsubscribe();
  const made = await worker.pushManager.subscribe({ userVisibleOnly: true, applicationServerKey: bytesOf(key) });
  const { endpoint, keys } = made.toJSON();
  if (endpoint === undefined || keys?.["p256dh"] === undefined || keys["auth"] === undefined) {
    throw new Error("The browser gave no address for messages.");
  }
  return { endpoint, p256dh: keys["p256dh"], auth: keys["auth"] };
}

/** Tells where a message leads that was clicked on while this page was open. Returns the way to end it. */
export function onOpened(show: (path: string) => void): () => void {
  if (!("serviceWorker" in navigator)) return () => undefined;
  const workers = navigator.serviceWorker;
  const onWorkerMessage = (event: MessageEvent<unknown>): void => {
    const said = event.data;
    if (typeof said === "object" && said !== null && "open" in said && typeof said.open === "string") show(said.open);
  };
  workers.addEventListener("message", onWorkerMessage);
  // A page that is not the worker's own gets nothing before it says that it listens.
  workers.startMessages();
  return () => {
    workers.removeEventListener("message", onWorkerMessage);
  };
}

function bytesOf(text: string): Uint8Array<ArrayBuffer> {
  const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  return Uint8Array.from(raw, (letter) => letter.charCodeAt(0));
}
