/** What stands in a film's place while there is none, and what says that a picture is blurred. */

import { html, type TemplateResult } from "lit";
import type { FilmShape } from "../../generated/api.js";
import type { CameraFilms } from "../../state/past/film-search.js";
import type { GalleryEntry } from "./entry.js";
import "../../tiles/camera/blur-button.js";
import "../../tiles/camera/film-view.js";

const NOON_US = 1_780_000_000_000_000;

function film(state: FilmShape["state"], note = ""): FilmShape {
  return {
    id: "1", stream: "base/front", state, why: "", who: "Ada", note, begin_us: NOON_US, end_us: NOON_US + 60e6, size: 1e7, have: 4.2e6, pictures: 1800,
  };
}

function renderView(us: number, change: Partial<CameraFilms>): TemplateResult {
  const reel: CameraFilms = { stream: "base/front", name: "Front camera", films: [], unfilmed: [], filming: false, ...change };
  return html`<t-film-view .reel=${reel} .us=${us} zone="Europe/Madrid"></t-film-view>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-blur-button",
    states: [
      { name: "blurred", show: () => html`<t-blur-button></t-blur-button>` },
      { name: "may be unblurred", show: () => html`<t-blur-button may></t-blur-button>` },
      { name: "unblurred", show: () => html`<t-blur-button may unblurred></t-blur-button>` },
    ],
  },
  {
    tag: "t-film-view",
    states: [
      { name: "none at this moment", show: () => renderView(NOON_US - 5e6, { films: [film("complete")] }) },
      { name: "being filmed", show: () => renderView(NOON_US, { filming: true }) },
      { name: "on its way", show: () => renderView(NOON_US + 5e6, { films: [film("uploading")] }) },
      { name: "lost", show: () => renderView(NOON_US + 5e6, { films: [film("failed", "its file is not there")] }) },
      {
        name: "only in the recording",
        show: () => renderView(NOON_US, { unfilmed: [{ recording: "1", stream: "base/front", begin_us: NOON_US, end_us: NOON_US + 60e6 }] }),
      },
    ],
  },
];
