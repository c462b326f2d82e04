/** The elements of accounts and admin pages in each of their states. */

import { html } from "lit";
import { passwordRules } from "../../format/password-rules.js";
import { ANY } from "../../state/rights.js";
import type { DeviceSummary, PasskeyList, RoleShape } from "../../generated/api.js";
import { draftsOf, withLevelEdited, matrixLines } from "../roles/permission-matrix.js";
import "../../elements/feedback/confirm.js";
import "../../elements/forms/copy-text.js";
import "../../elements/values/qr-code.js";
import "../../elements/forms/rule-list.js";
import "../admin-tabs.js";
import "../account/passkeys.js";
import "../roles/role-factors.js";
import "../roles/role-matrix.js";
import "../shell/confirm-person.js";
import type { GalleryEntry } from "./entry.js";

/** Three corners, as every QR code has; it holds nothing. */
const QR =
  '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 29 29"><path d="M4 4h7v7H4zM18 4h7v7h-7zM4 18h7v7H4z' +
  'M13 13h3v3h-3zM18 18h2v2h-2zM22 22h3v3h-3zM14 20h2v4h-2z" fill="#000"/><path d="M5 5h5v5H5zM19 5h5v5h-5zM5 19h5v5H5z" fill="#fff"/>' +
  '<path d="M6 6h3v3H6zM20 6h3v3h-3zM6 20h3v3H6z" fill="#000"/></svg>';

const row = (device: string, name: string, open: boolean): DeviceSummary => ({
  site: "agv", site_name: "House vehicle", device, name, kind: "other", online: true, rights: [], public: open,
  signals: 1, stale: 0,
});
const NO_PASSKEYS: PasskeyList = { passkeys: [], codes: false, possible: true };
const TWO_PASSKEYS: PasskeyList = {
  passkeys: [
    { id: "1", name: "Phone", host: "hub.example", created_us: 1_700_000_000_000_000, used_us: 1_700_000_600_000_000 },
    { id: "2", name: "Key on my ring", host: "hub.example", created_us: 1_700_000_000_000_000, used_us: 0 },
  ],
  codes: true, possible: true,
};
const DEVICES = [row("base", "Vehicle base", true), row("camera", "Camera", false)];
const ROLES: readonly RoleShape[] = [
  { id: "1", name: "guest", seeded: true, factor_required: false, people: 4, permissions: [] },
  { id: "2", name: "operator", seeded: true, factor_required: false, people: 1, permissions: [{ right: "use", site: ANY, device: ANY }] },
  { id: "3", name: "admin", seeded: true, factor_required: true, people: 1, permissions: [{ right: "admin", site: ANY, device: ANY }] },
  { id: "4", name: "camera crew", seeded: false, factor_required: false, people: 0, permissions: [{ right: "view", site: "agv", device: "camera" }] },
];
const LINES = matrixLines(DEVICES, ROLES);
const CHANGED = withLevelEdited(draftsOf(ROLES), "4", { site: "agv", device: "base" }, "use");

function openQuestion(event: Event): void {
  if (!(event.currentTarget instanceof HTMLElement)) return;
  const question = event.currentTarget.parentElement?.querySelector("t-confirm");
  if (question) question.open = true;
}

function askPerson(event: Event): void {
  if (!(event.currentTarget instanceof HTMLElement)) return;
  void event.currentTarget.parentElement?.querySelector("t-confirm-person")?.askPerson();
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-role-matrix",
    wide: true,
    states: [
      { name: "as saved", show: () => html`<t-role-matrix .lines=${LINES} .drafts=${draftsOf(ROLES)}></t-role-matrix>` },
      { name: "one cell changed", show: () => html`<t-role-matrix .lines=${LINES} .drafts=${CHANGED}></t-role-matrix>` },
      { name: "being saved", show: () => html`<t-role-matrix busy .lines=${LINES} .drafts=${CHANGED}></t-role-matrix>` },
    ],
  },
  {
    tag: "t-role-factors",
    wide: true,
    states: [{ name: "admins need one", show: () => html`<t-role-factors class="sheet" .roles=${ROLES}></t-role-factors>` }],
  },
  {
    tag: "t-account-passkeys",
    wide: true,
    states: [
      { name: "none", show: () => html`<t-account-passkeys class="sheet" .list=${NO_PASSKEYS}></t-account-passkeys>` },
      { name: "two", show: () => html`<t-account-passkeys class="sheet" .list=${TWO_PASSKEYS}></t-account-passkeys>` },
    ],
  },
  {
    tag: "t-admin-tabs",
    wide: true,
    states: [{ name: "on a page", show: () => html`<t-admin-tabs page="roles"></t-admin-tabs>` }],
  },
  {
    tag: "t-copy",
    wide: true,
    states: [
      {
        name: "a command",
        show: () => html`<t-copy label="Command" text="talaia gateway enrol https://hub.example AAAAA-BBBBB-CCCC"></t-copy>`,
      },
      { name: "lines", show: () => html`<t-copy label="Recovery codes" .text=${"aaaa-bbbb\ncccc-dddd"}></t-copy>` },
    ],
  },
  { tag: "t-qr", states: [{ name: "drawn by the hub", show: () => html`<t-qr .svg=${QR} label="An example that holds nothing"></t-qr>` }] },
  {
    tag: "t-rules",
    states: [
      { name: "nothing typed", show: () => html`<t-rules .rules=${passwordRules("", "Ada", "")}></t-rules>` },
      { name: "some kept", show: () => html`<t-rules .rules=${passwordRules("eight888", "Ada", "")}></t-rules>` },
      {
        name: "all kept",
        show: () => html`<t-rules .rules=${passwordRules("a quiet sentence", "Ada", "a quiet sentence")}></t-rules>`,
      },
    ],
  },
  {
    tag: "t-confirm-person",
    states: [
      {
        name: "press to open",
        show: () => html`<t-button @click=${askPerson}>Make Ada an admin…</t-button><t-confirm-person></t-confirm-person>`,
      },
    ],
  },
  {
    tag: "t-confirm",
    states: [
      {
        name: "press to open",
        show: () => html`<t-button @click=${openQuestion}>Revoke…</t-button
          ><t-confirm heading="Revoke the key?" action="Revoke it" keep="Keep it"><p>Its link is closed at once.</p></t-confirm>`,
      },
      {
        name: "it failed (press to open)",
        show: () => html`<t-button @click=${openQuestion}>Remove…</t-button
          ><t-confirm
            heading="Remove Ada?"
            action="Remove"
            .problem=${{ what: "The hub did not remove Ada.", how: "There must be one admin." }}
            ><p>It cannot be taken back.</p></t-confirm
          >`,
      },
    ],
  },
];
