// Shows messages about alarms that the hub sends while no page of it is open (Web Push).
self.addEventListener("push", (event) => {
  let said = { key: "", title: "Talaia", body: "" };
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
      requireInteraction: said.severity === "critical",
    }),
  );
});

self.addEventListener("notificationclick", (event) => {
  event.notification.close();
  event.waitUntil(
    (async () => {
      const pages = await self.clients.matchAll({ type: "window" });
      const open = pages.find((page) => new URL(page.url).pathname === "/alarms");
      if (open !== undefined) await open.focus();
      else await self.clients.openWindow("/alarms");
    })(),
  );
});
