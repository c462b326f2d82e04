// Shows messages about alarms that the hub sends while no page of it is open (Web Push).
const ALARMS = "/alarms";

self.addEventListener("push", (event) => {
  let said = { key: "", title: "Talaia", body: "", open: ALARMS, picture: "" };
  try {
    said = { ...said, ...event.data.json() };
  } catch {
    // A message that is not ours: only that there is one.
  }
  event.waitUntil(
    self.registration.showNotification(said.title, {
      body: said.body,
      // The same message once more takes the place of the first.
      tag: said.key,
      icon: "/icon.svg",
      ...pictureOf(said.picture),
      requireInteraction: said.severity === "critical",
      data: { open: said.open },
    }),
  );
});

self.addEventListener("notificationclick", (event) => {
  event.notification.close();
  event.waitUntil(show(pathOf(event.notification.data?.open)));
});

/** A page of alarms that is open goes there; any other stays: somebody may be driving in it. */
async function show(path) {
  const pages = await self.clients.matchAll({ type: "window", includeUncontrolled: true });
  const open = pages.find((page) => new URL(page.url).pathname === ALARMS);
  if (open === undefined) {
    await self.clients.openWindow(path);
    return;
  }
  await open.focus();
  open.postMessage({ open: path });
}

/** Only a picture of a sighting at this very hub, which gives it to who is signed in and may see it. */
function pictureOf(path) {
  if (typeof path !== "string" || path === "") return {};
  const url = new URL(path, self.location.origin);
  const ours = url.origin === self.location.origin && /^\/api\/sites\/[^/]+\/sightings\/\d+\/picture$/.test(url.pathname);
  return ours ? { image: url.pathname } : {};
}

/** Only a page of alarms of this very hub is opened, whatever a message says. */
function pathOf(open) {
  const url = new URL(typeof open === "string" ? open : ALARMS, self.location.origin);
  return url.origin === self.location.origin && url.pathname === ALARMS ? url.pathname + url.search : ALARMS;
}
