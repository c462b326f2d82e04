/** Which maps may be shown, and which one somebody chose. Pure but for what it is handed. */

import { msg } from "@lit/localize";
import type { MapOffer, MapSession } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";

/** The coarse world that the pages bring along. */
export const WORLD = "world";

export interface GroundChoice {
  /** `world`, `file NAME` or `source ID` */
  readonly key: string;
  readonly label: string;
  /** Whom a browser asks for its tiles besides this hub; empty for nobody. */
  readonly host: string;
}

/** All choices; the first one is taken by who chose none. */
export function groundChoices(offer: MapOffer | null): GroundChoice[] {
  const files = (offer?.files ?? []).map(({ name }) => ({ key: `file ${name}`, label: name, host: "" }));
  const sources = (offer?.sources ?? []).map(({ id, name, host }) => ({ key: `source ${id}`, label: name, host }));
  // One's own file comes first: it asks nobody. One that asks others is never taken unasked.
  return [...files, { key: WORLD, label: msg("World (coarse)"), host: "" }, ...sources];
}

export function chosenGround(choices: readonly GroundChoice[], wanted: string): GroundChoice {
  return choices.find(({ key }) => key === wanted) ?? choices[0] ?? { key: WORLD, label: msg("World (coarse)"), host: "" };
}

export const loadOffer = (api: Pick<HubApi, "request">): Promise<MapOffer> => api.request("GET", "/api/maps");

/** The address of the tiles of a source that is asked by sessions. */
export const openSession = (api: Pick<HubApi, "request">, id: string): Promise<MapSession> =>
  api.request("GET", `/api/maps/sources/${encodeURIComponent(id)}/session`);
