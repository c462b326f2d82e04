/** Who is signed in. */

import type { Me } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";
import { usePasskey } from "../wire/passkeys.js";
import { Store } from "./store.js";

/**
 * - `unknown`: not asked yet
 * - `nobody`: the hub knows nobody here
 * - `ended`: the session of `person` is over, and their page waits for them to sign in again
 * - `known`: `person` says who
 */
export type SessionState = "unknown" | "nobody" | "ended" | "known";

const NOTE = "talaia.signed-in";
/** A page that nobody comes back to asks on for hours: the oldest of so many questions are given up. */
const MOST_WAITING = 64;

export class Session extends Store {
  private someone: Me | null = null;
  private asked = false;
  private going = false;
  private over = false;
  private waiting: ((back: boolean) => void)[] = [];

  /** @param notes - where this browser remembers that somebody signed in; null when it may not */
  constructor(
    private readonly api: HubApi,
    private readonly notes: Pick<Storage, "getItem" | "setItem" | "removeItem"> | null = null,
  ) {
    super();
  }

  /**
   * Whether somebody may be signed in. The cookie itself cannot be seen from here: who opens the
   * sign-in page without ever having signed in need not be asked about.
   */
  get mayExist(): boolean {
    return this.notes === null || this.notes.getItem(NOTE) !== null;
  }

  get state(): SessionState {
    if (!this.asked) return "unknown";
    if (this.over) return "ended";
    return this.someone === null ? "nobody" : "known";
  }

  get person(): Me | null {
    return this.someone;
  }

  /** The hub is being told that the person goes. */
  get isSigningOut(): boolean {
    return this.going;
  }

  /** Whether another tab of this browser has written that somebody signed in or out. */
  isNews(key: string | null): boolean {
    return key === NOTE;
  }

  /** Somebody else signed in where a person's page waits: nothing of it may be left. */
  onOtherPerson: (() => void) | null = null;

  /** Why the last session ended, for the sign-in page; empty when nobody needs to be told. */
  notice = "";

  /** Nobody can be signed in here: known without asking the hub. */
  assumeNobody(): void {
    this.setPerson(null);
  }

  /**
   * Asks the hub who we are, without making the session live longer.
   *
   * @throws Unreachable
   */
  async refresh(): Promise<void> {
    const person = await this.api.currentPerson();
    if (person === null && this.someone !== null && this.someone.role !== "display") this.endInPlace();
    else this.setPerson(person);
  }

  /** Tells the hub that the person is still here. @throws Unreachable */
  async extend(): Promise<void> {
    this.setPerson(await this.api.currentPerson(false));
  }

  /** @throws Refused, Unreachable */
  async login(name: string, password: string, code = ""): Promise<void> {
    const person = await this.api.login(name, password, code);
    this.notice = "";
    this.setPerson(person);
  }

  /** By a passkey: after name and password, or without both. @throws Refused, Unreachable */
  async loginByPasskey(name = "", password = ""): Promise<void> {
    const person = await this.api.loginByPasskey(await usePasskey(await this.api.passkeySignIn(name, password)));
    this.notice = "";
    this.setPerson(person);
  }

  /** Nobody is signed in afterwards, also when the hub could not be told. */
  async logout(): Promise<void> {
    this.going = true;
    this.notifyWatchers();
    try {
      await this.api.logout();
    } finally {
      this.going = false;
      this.notice = "";
      this.setPerson(null);
    }
  }

  /** Gives, when it is known, whether the person is here again; false: they are not coming. */
  waitUntilBack(): Promise<boolean> {
    if (this.state !== "ended") return Promise.resolve(this.state === "known");
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      if (this.waiting.length > MOST_WAITING) this.waiting.shift()?.(false);
    });
  }

  /** The person whose session ended does not come back to their page. */
  forget(): void {
    if (this.over) this.setPerson(null);
  }

  /** Changes when somebody else is here, or the same person may do other things than before. */
  get rightsKey(): string {
    return rightsOf(this.someone);
  }

  private endInPlace(): void {
    if (this.over) return;
    this.over = true;
    this.notes?.removeItem(NOTE);
    this.notifyWatchers();
  }

  private setPerson(person: Me | null): void {
    if (this.over && person !== null && person.name !== this.someone?.name) {
      // What waits stays covered until all of it is gone.
      this.notes?.setItem(NOTE, "1");
      this.onOtherPerson?.();
      return;
    }
    const same = this.asked && !this.over && isSamePerson(person, this.someone);
    if (this.over) this.notice = "";
    this.asked = true;
    this.over = false;
    this.someone = person;
    if (person === null) this.notes?.removeItem(NOTE);
    else this.notes?.setItem(NOTE, "1");
    if (!same) this.notifyWatchers();
    for (const answer of this.waiting.splice(0)) answer(person !== null);
  }
}

/** Watchers are told of everything but the idle time, which moves all the time. */
function isSamePerson(a: Me | null, b: Me | null): boolean {
  return rightsOf(a) === rightsOf(b) && a?.factor === b?.factor && a?.password === b?.password && a?.codes_locked_us === b?.codes_locked_us;
}

function rightsOf(person: Me | null): string {
  return person === null ? "" : JSON.stringify([person.name, person.role, person.admin, person.factor_missing, person.permissions]);
}
