import { describe, expect, test } from "vitest";
import { tickText } from "../../src/series/time-ticks.js";
import { HOUR_US, MINUTE_US, SECOND_US, ZoneClock } from "../../src/series/zone-clock.js";
import { useLanguage } from "../../src/words/locale.js";
import { knownZone, localSpan, timeText, utcSpan, zoneName } from "../../src/format/time.js";

describe("moments", () => {
  const summer = Date.UTC(2026, 6, 1, 12, 5, 9) * 1000;

  test("today's moment has no date, and UTC beside it", () => {
    const text = timeText(summer, "Europe/Madrid", summer);
    expect([text.local, text.utc, text.machine]).toEqual(["14:05:09", "12:05:09 UTC", "2026-07-01T12:05:09.000Z"]);
  });

  test("another day's moment has its date, each side its own", () => {
    const late = Date.UTC(2026, 6, 1, 23, 0, 0) * 1000;
    const text = timeText(late, "Europe/Madrid", summer + 86_400_000_000 * 3);
    expect([text.local, text.utc]).toEqual(["2 Jul 2026, 01:00:00", "1 Jul 2026, 23:00:00 UTC"]);
  });

  test("the zone's name follows summer time", () => {
    const winter = Date.UTC(2026, 0, 1) * 1000;
    expect(zoneName(summer, "Europe/Madrid")).not.toBe(zoneName(winter, "Europe/Madrid"));
  });

  test("headings and axes read one clock of 24 hours, in the site's zone and in any language", () => {
    for (const language of ["en", "ca", "es", "en-US"]) {
      useLanguage(language);
      for (const zone of ["Europe/Madrid", "America/Caracas", "Asia/Kolkata", "UTC"]) {
        const clock = new ZoneClock(zone);
        for (let hour = 0; hour < 24; hour++) {
          const moment = summer + hour * HOUR_US;
          const heading = timeText(moment, zone, moment).local;
          expect(heading).toMatch(/^[0-2][0-9]:[0-5][0-9]:[0-5][0-9]$/);
          expect(tickText(moment, SECOND_US, clock)).toBe(heading);
          expect(heading.startsWith(tickText(moment, MINUTE_US, clock))).toBe(true);
        }
      }
    }
    useLanguage("en");
  });

  test("a zone that this browser does not know counts as UTC", () => {
    expect(knownZone("Moon/Tycho")).toBe("UTC");
    expect(timeText(summer, "Moon/Tycho", summer).local).toBe("12:05:09");
  });
});

describe("beside the site's own", () => {
  const day = Date.UTC(2026, 0, 10, 12) * 1000;

  test("a stretch of time stands in UTC too", () => {
    expect(utcSpan({ fromUs: day, toUs: day + 60e6 }, "Europe/Madrid", day)).toBe("12:00:00 – 12:01:00 UTC");
    expect(localSpan({ fromUs: day, toUs: day + 60e6 }, "America/Caracas", day)).toBe("08:00:00 – 08:01:00 GMT-4");
  });

  test("a site that lives in UTC has nothing beside it", () => {
    expect(utcSpan({ fromUs: day, toUs: day + 60e6 }, "UTC", day)).toBe("");
  });
});
