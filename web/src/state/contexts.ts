/** What pages and elements may ask for, each by its own concern. */

import { createContext } from "@lit/context";
import type { Connection } from "../wire/connection.js";
import type { HubApi } from "../wire/hub-api.js";
import type { AlarmSound } from "./alarm-sound.js";
import type { Alarms } from "./alarms.js";
import type { DeviceHolders } from "./device-holders.js";
import type { Locks } from "./interlocks.js";
import type { ReadingSource } from "./live-values.js";
import type { Reachability } from "./device-reachability.js";
import type { PastBoard } from "./past/past-board.js";
import type { RobotState } from "./robot-state.js";
import type { Router } from "./router.js";
import type { Session } from "./session.js";
import type { Sites } from "./sites.js";
import type { ThemeChoice } from "./theme.js";

export const alarmsContext = createContext<Alarms>(Symbol("alarms"));
export const alarmSoundContext = createContext<AlarmSound>(Symbol("alarm sound"));
export const apiContext = createContext<HubApi>(Symbol("api"));
export const connectionContext = createContext<Connection>(Symbol("connection"));
export const deviceHoldersContext = createContext<DeviceHolders>(Symbol("device holders"));
export const interlocksContext = createContext<Locks>(Symbol("interlocks"));
export const liveContext = createContext<ReadingSource>(Symbol("live"));
/** The past moment that what stands here shows; nobody provides one where all is of now. */
export const pastContext = createContext<PastBoard>(Symbol("past"));
export const reachContext = createContext<Reachability>(Symbol("reach"));
export const robotNewsContext = createContext<RobotState>(Symbol("robot news"));
export const routerContext = createContext<Router>(Symbol("router"));
export const sessionContext = createContext<Session>(Symbol("session"));
export const sitesContext = createContext<Sites>(Symbol("sites"));
/** What opens the sockets of raw topics and of pictures; nobody provides it where they go to the hub. */
export const socketsContext = createContext<(url: string) => WebSocket>(Symbol("sockets"));
export const themeContext = createContext<ThemeChoice>(Symbol("theme"));
