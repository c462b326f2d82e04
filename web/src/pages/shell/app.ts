/** Builds every part of the dashboard once and hands them down by contexts. */

import { ContextProvider } from "@lit/context";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import {
  alarmsContext,
  alarmSoundContext,
  apiContext,
  connectionContext,
  deviceHoldersContext,
  interlocksContext,
  liveContext,
  reachContext,
  robotNewsContext,
  routerContext,
  sessionContext,
  sitesContext,
  themeContext,
} from "../../state/contexts.js";
import { AlarmSound } from "../../state/alarm-sound.js";
import { Alarms } from "../../state/alarms.js";
import { DeviceHolders } from "../../state/device-holders.js";
import { Interlocks } from "../../state/interlocks.js";
import { LiveValues } from "../../state/live-values.js";
import { DeviceReachability } from "../../state/device-reachability.js";
import { RobotState } from "../../state/robot-state.js";
import { Router } from "../../state/router.js";
import { Session } from "../../state/session.js";
import { Sites } from "../../state/sites.js";
import { SleepWatch } from "../../controllers/sleep-watch.js";
import { ThemeChoice } from "../../state/theme.js";
import { UserActivity } from "../../state/user-activity.js";
import { comeback } from "../../wire/backoff.js";
import { Connection } from "../../wire/connection.js";
import { HubApi, Unreachable } from "../../wire/hub-api.js";
import { socketUrl } from "../../wire/media-socket.js";
import { registerWorker } from "../../worker/shell-worker.js";
import { onOpened } from "../../wire/web-push.js";
import { firstPage, isOpen } from "../routes.js";
import { allWords } from "../../words/language.js";
import type { ConfirmPerson } from "./confirm-person.js";
import "./confirm-person.js";
import "./shell.js";
import "./sign-in-again.js";

/** A session that was taken up again this long ago (ms) may be at once. */
const RESUME_PAUSE_MS = 10_000;
/** Whether the device slept is looked at this often (ms). */
const SLEEP_EVERY_MS = 1000;

@customElement("t-app")
export class App extends LitElement {
  @state() private unreachable = false;
  /** The pages were updated while this one was open. */
  @state() private outdated = false;
  @query("t-confirm-person") private readonly question!: ConfirmPerson;

  private readonly api = new HubApi();
  private readonly touched = new UserActivity(window);
  private readonly connection = new Connection({
    url: socketUrl("/ws", location),
    touched: () => this.touched.consumeTouch(),
  });
  private readonly alarms = new Alarms(this.connection);
  private readonly alarmSound = new AlarmSound(browserStorage());
  private readonly deviceHolders = new DeviceHolders(this.connection);
  private readonly interlocks = new Interlocks(this.connection);
  private readonly live = new LiveValues(this.connection);
  private readonly reach = new DeviceReachability(this.connection);
  private readonly robotNews = new RobotState(this.connection);
  private readonly router = new Router(window);
  private readonly session = new Session(this.api, browserStorage());
  private readonly sites = new Sites(this.api);
  private readonly theme = new ThemeChoice(document.documentElement, browserStorage());
  private readonly sleep = new SleepWatch();
  private sleepTimer: ReturnType<typeof setInterval> | undefined;
  private readonly checkVersion = registerWorker(navigator.serviceWorker, () => {
    this.outdated = true;
  });
  private stops: (() => void)[] = [];
  private rights = "";
  private resumedAt = Number.NEGATIVE_INFINITY;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  /** The question who is signed in, while it is under way. */
  private asking: Promise<void> | null = null;

  constructor() {
    super();
    new ContextProvider(this, { context: alarmsContext, initialValue: this.alarms });
    new ContextProvider(this, { context: alarmSoundContext, initialValue: this.alarmSound });
    new ContextProvider(this, { context: apiContext, initialValue: this.api });
    new ContextProvider(this, { context: connectionContext, initialValue: this.connection });
    new ContextProvider(this, { context: deviceHoldersContext, initialValue: this.deviceHolders });
    new ContextProvider(this, { context: interlocksContext, initialValue: this.interlocks });
    new ContextProvider(this, { context: liveContext, initialValue: this.live });
    new ContextProvider(this, { context: reachContext, initialValue: this.reach });
    new ContextProvider(this, { context: robotNewsContext, initialValue: this.robotNews });
    new ContextProvider(this, { context: routerContext, initialValue: this.router });
    new ContextProvider(this, { context: sessionContext, initialValue: this.session });
    new ContextProvider(this, { context: sitesContext, initialValue: this.sites });
    new ContextProvider(this, { context: themeContext, initialValue: this.theme });
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.touched.start();
    window.addEventListener("pointerdown", this.onUserActivity, { capture: true });
    window.addEventListener("keydown", this.onUserActivity, { capture: true });
    window.addEventListener("online", this.onWake);
    window.addEventListener("storage", this.onOtherTab);
    document.addEventListener("visibilitychange", this.onWake);
    this.sleepTimer = setInterval(this.checkSleep, SLEEP_EVERY_MS);
    this.stops = [
      this.session.subscribe(this.onSessionChange),
      onOpened((path) => {
        this.router.navigate(path);
      }),
      this.alarms.subscribe(() => {
        this.alarmSound.soundIfMore(this.alarms.raised);
      }),
      this.router.subscribe(this.redirectIfNeeded),
      this.connection.onMessage("site", (news) => {
        this.sites.applyUpdate(news);
      }),
      this.connection.onState((link) => {
        if (link === "open") {
          void this.sites.load();
          comeback.announce();
          // A hub that was away may have been updated.
          this.checkVersion();
        }
        // A hub that refuses the socket does not say why; the session does.
        if (link === "ended") this.session.notice = this.connection.endedReason;
        if (link === "lost" || link === "ended") void this.refreshSession();
      }),
    ];
    // The socket may outlive its session, or wait to be tried again: a page that asks finds out first.
    this.api.onSignedOut = async () => {
      if (this.session.state === "known") await this.refreshSession();
      return this.session.waitUntilBack();
    };
    this.session.onOtherPerson = () => {
      window.location.reload();
    };
    void this.refreshSession();
  }

  override firstUpdated(): void {
    this.api.confirmPerson = this.question.askPerson;
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.touched.stop();
    window.removeEventListener("pointerdown", this.onUserActivity, { capture: true });
    window.removeEventListener("keydown", this.onUserActivity, { capture: true });
    window.removeEventListener("online", this.onWake);
    window.removeEventListener("storage", this.onOtherTab);
    document.removeEventListener("visibilitychange", this.onWake);
    clearTimeout(this.retryTimer);
    clearInterval(this.sleepTimer);
    for (const stop of this.stops) stop();
    this.stops = [];
    this.connection.stop();
  }

  override render(): TemplateResult {
    return html`<t-shell ?unreachable=${this.unreachable} ?outdated=${this.outdated}></t-shell><t-confirm-person></t-confirm-person><t-sign-in-again></t-sign-in-again>`;
  }

  /** A browser is silent until somebody has touched the page. */
  private readonly onUserActivity = (): void => {
    this.alarmSound.unlockAudio();
  };

  private readonly onWake = (): void => {
    if (document.visibilityState !== "visible") return;
    this.checkSleep();
    this.connection.retryNow();
  };

  /** After a sleep what is shown is older than it looks, and sockets may be dead that nobody closed. */
  private readonly checkSleep = (): void => {
    const { slept, uncountedMs } = this.sleep.checkClocks();
    if (!slept) return;
    if (uncountedMs > 0) this.live.addAge(uncountedMs);
    this.connection.probe();
  };

  /** Somebody signed in or out in another tab of this browser: here, too. */
  private readonly onOtherTab = (event: StorageEvent): void => {
    if (this.session.isNews(event.key)) void this.refreshSession();
  };

  private readonly onSessionChange = (): void => {
    if (this.session.rightsKey !== this.rights) {
      // Somebody else, or the same person with other rights: what was shown may not be theirs.
      this.rights = this.session.rightsKey;
      this.sites.clear();
      this.live.clear();
    }
    if (this.mayConnect()) this.connect();
    else this.connection.stop();
    this.redirectIfNeeded();
  };

  /** Sends whoever is not signed in to the sign-in page and back again afterwards; others to their first page. */
  private readonly redirectIfNeeded = (): void => {
    const { person } = this.session;
    if (person !== null && this.router.route.page === "home" && this.router.path !== firstPage(person)) {
      this.router.replace(firstPage(person));
      return;
    }
    // What anybody may open does not wait for a person.
    if (isOpen(this.router.route.page)) this.session.forget();
    if (this.session.state !== "nobody" || isOpen(this.router.route.page)) return;
    if (this.router.path === "/") {
      this.router.replace("/login");
      return;
    }
    const query = new URLSearchParams({ return: this.router.path });
    this.router.replace(`/login?${query.toString()}`);
  };

  /** Once the words of all pages are there: what hub and gateways say is translated as it arrives. */
  private connect(): void {
    if (!this.mayConnect()) return;
    void allWords().then(() => {
      if (this.mayConnect()) this.connection.start();
    });
  }

  /** Who has to set up a second factor first is let in to nothing else. */
  private mayConnect(): boolean {
    return this.session.state === "known" && this.session.person?.factor_missing === false;
  }

  /** The session goes on with other rights, or another tab signed in anew: a fresh socket is ours. */
  private resumeConnection(): void {
    if (!this.mayConnect() || this.connection.state !== "ended") return;
    this.session.notice = "";
    // Once at once; a hub that ends each session would be asked without a pause.
    const now = performance.now();
    const soon = now - this.resumedAt > RESUME_PAUSE_MS;
    this.resumedAt = now;
    this.retryTimer = setTimeout(
      () => {
        this.connect();
      },
      soon ? 0 : 1000,
    );
  }

  private refreshSession(): Promise<void> {
    this.asking ??= this.loadSession().finally(() => {
      this.asking = null;
    });
    return this.asking;
  }

  private async loadSession(): Promise<void> {
    clearTimeout(this.retryTimer);
    if (this.session.state === "unknown" && this.router.route.page === "login" && !this.session.mayExist) {
      this.session.assumeNobody();
      return;
    }
    try {
      await this.session.refresh();
      this.unreachable = false;
      this.resumeConnection();
    } catch (error) {
      this.unreachable = error instanceof Unreachable;
      if (this.session.state === "unknown") {
        this.retryTimer = setTimeout(() => void this.refreshSession(), 3000);
      }
    }
  }
}

/** A browser that forbids storage throws at the mere mention of it. */
function browserStorage(): Storage | null {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-app": App;
  }
}
